#include <array>

#include "core/rig/unstated.hpp"
#include "daemon/serve/element_standing.hpp"
#include "daemon/serve/metrics.hpp"

namespace dwell {
namespace {

// A coefficient's families: their names carry the unit, which the rig's motion decides.
struct CoefficientNames {
  const char* value;
  const char* U95;
};
struct MotionNames {
  CoefficientNames stiffness, damping;
};
constexpr MotionNames kTranslation{
    {"dwell_stiffness_newtons_per_meter", "dwell_stiffness_u95_newtons_per_meter"},
    {"dwell_damping_newton_seconds_per_meter", "dwell_damping_u95_newton_seconds_per_meter"}};
constexpr MotionNames kRotation{
    {"dwell_stiffness_newton_meters_per_radian", "dwell_stiffness_u95_newton_meters_per_radian"},
    {"dwell_damping_newton_meter_seconds_per_radian", "dwell_damping_u95_newton_meter_seconds_per_radian"}};

// Calls `call` with each element whose numbers may be handed out and its label.
template <class Call>
void each_element(const ServiceView& now, Call call) {
  for (int k = 1; k <= now.rig.element_count(); ++k) {
    const std::string label = std::to_string(k);
    if (const ElementEstimate* const element = element_to_hand_out(now, k))
      call(*element, Exposition::Labels{{"element", label}});
  }
}

void write_coefficients(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_element_standing",
            "How each element's numbers stand: 1 for what holds. They are absent unless valid or doubtful.");
  for (int k = 1; k <= now.rig.element_count(); ++k)
    write_states(out, "standing", standing_of(now, k), kStandings, {{"element", std::to_string(k)}});

  const MotionNames& names = now.rig.motion == Motion::translation ? kTranslation : kRotation;
  const auto write = [&](const CoefficientNames& name, Coefficient ElementEstimate::*which, const std::string& what) {
    out.gauge(name.value, "The element's " + what + ".");
    each_element(now, [&](const ElementEstimate& e, const auto& labels) { out.sample((e.*which).value, labels); });
    out.gauge(name.U95, "Half width of the 95 % interval of the element's " + what + ".");
    each_element(now, [&](const ElementEstimate& e, const auto& labels) { out.sample((e.*which).U95, labels); });
  };
  write(names.stiffness, &ElementEstimate::stiffness, "stiffness");
  write(names.damping, &ElementEstimate::damping, "damping");
  out.gauge("dwell_unstated_info",
            "1 beside each uncertainty that the rig file does not state. The 95 % intervals do not cover it.");
  for (const std::string& what : unstated_uncertainties(now.rig)) out.sample(1.0, {{"what", what}});
  out.gauge("dwell_loss_factor_ratio", "The element's loss factor, omega r / c.");
  each_element(now, [&](const ElementEstimate& e, const auto& labels) { out.sample(e.loss_factor.value, labels); });
}

void write_model(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_model_error_limit_ratio",
            "Largest error of a prediction that is asked for, as part of a channel's rms.");
  out.sample(now.verification.accuracy);
  if (is_stale(now)) return;
  const auto model = live_dwell(now).model;
  constexpr std::array kVerdicts{Verdict::adequate, Verdict::not_adequate, Verdict::not_verified};
  out.gauge("dwell_model_verdict", "The verdict on the current dwell's model: 1 for what holds.");
  write_states(out, "verdict", model ? model->verdict : Verdict::not_verified, kVerdicts);
  if (!model) return;
  out.gauge(
      "dwell_model_consistent",
      "Whether noise and stated uncertainties explain all that the model leaves over: 1 yes, 0 no. Absent: it could "
      "not be asked.");
  if (model->consistent) out.sample(*model->consistent ? 1 : 0);
  out.gauge("dwell_model_contradicted",
            "Whether the method of any motion holds something against the current dwell: 1 yes. 0: no, or it was not "
            "asked yet.");
  out.sample(model->objection.empty() ? 0 : 1);
  out.gauge("dwell_model_error_ratio",
            "Error of the model's prediction in the channel that decides, as part of its rms.");
  out.sample(model->seen);
  out.gauge("dwell_model_error_uncertainty_ratio", "Expanded uncertainty (k = 2) of dwell_model_error_ratio.");
  out.sample(model->U);
}

void write_limits(const ServiceView& now, Exposition& out) {
  if (is_stale(now)) return;
  constexpr std::array kVerdicts{LimitVerdict::none, LimitVerdict::kept, LimitVerdict::undecided,
                                 LimitVerdict::violated};
  out.gauge("dwell_limit_verdict",
            "The verdict on each limit of the rig file, by the current dwell: 1 for what holds. none: nothing is "
            "measured, or there is no number that may be relied on.");
  for (const JudgedLimit& limit : judge_limits_now(now.rig, now.snapshot.dwell))
    write_states(out, "verdict", limit.verdict, kVerdicts,
                 {{"element", std::to_string(limit.element)}, {"coefficient", to_string(limit.kind)}});
}

// Of the current dwell, whose state is known.
void write_dwell(const Dwell& dwell, Exposition& out) {
  constexpr std::array kStates{State::idle, State::settling, State::measuring, State::complete, State::fault};
  out.gauge("dwell_state", "State of the current dwell: 1 for what holds. Absent: the estimation does not say.");
  write_states(out, "state", dwell.state, kStates);
  out.gauge("dwell_index", "Index of the current dwell within its run. Absent: there is none.");
  if (dwell.index) out.sample(*dwell.index);
  out.gauge("dwell_settles_in_seconds", "Remaining time until the dwell has settled. Absent: not known, or it has.");
  if (dwell.state == State::settling) out.sample(dwell.settles_in_s);
  if (dwell.state != State::measuring) return;
  out.gauge("dwell_data_seconds", "Length of the data that count in the current dwell.");
  out.sample(dwell.end_s - dwell.settled_s);
  out.gauge("dwell_frequency_hertz", "Frequency of the drive, while a dwell is measured.");
  out.sample(dwell.frequency_hz.value);
  out.gauge("dwell_frequency_uncertainty_hertz", "Standard uncertainty of dwell_frequency_hertz.");
  out.sample(dwell.frequency_hz.u);
}

}  // namespace

void write_measurement_metrics(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_estimate_age_seconds", "Since the estimation last published.");
  out.sample(estimate_age_s(now.snapshot, now.now_ns));
  out.gauge("dwell_ready",
            "1: a dwell is measured now whose coefficients may be relied on, and the interlock is not open.");
  out.sample(now.health.ready ? 1.0 : 0.0);
  if (!is_stale(now)) write_dwell(now.snapshot.dwell, out);
  out.counter("dwell_finished_dwells_total", "Dwells of the run that have ended.");
  out.sample(count_value((now.snapshot.finished ? now.snapshot.finished->size() : 0) + now.snapshot.forgotten));
  write_coefficients(now, out);
  write_limits(now, out);
  write_model(now, out);
}

}  // namespace dwell
