#include <Eigen/Geometry>

#include "core/base/wording.hpp"
#include "core/dwell/pipeline_impl.hpp"
#include "core/fit/drive_harmonic.hpp"
#include "core/fit/folded.hpp"

namespace dwell {
namespace {

// Longest time left that is stated, in times watched so far. The time left is extrapolated from the decay seen so far.
// If it is so long, the slowest oscillation has lost a few percent of its size at most. Noise and a wrong pole look
// like that even if nothing decays. Halved: slow rigs go without a time for longer. Doubled: more times that mean
// nothing.
constexpr double kFarthest = 100.0;
// Assumed mean of errors over their standard deviation: right if they lie evenly between 0 and a largest one, or if
// three quarters of the readings have one and the same. More than that is not covered.
constexpr double kMeanOverScatter = std::numbers::sqrt3;
// From this part of a phasor's other uncertainty on, uneven readings are told: they widen it by 12 %. Halved: warnings
// of 3 %. Doubled: 41 % go unsaid.
constexpr double kUnevenMatters = 0.5;

}  // namespace

// Noise below half a step does not smooth rounding. If the sampling rate is near a multiple of the frequency, rounding
// then repeats with the motion: one period has all its independent errors.
double Pipeline::Impl::quantization_u(int c, const HarmonicFit& fit, const Totals& from) const {
  const double step = live[c].intake().step();
  if (!fit.usable || !std::isfinite(step) || !(fit.sigma2 < step * step * kRounded)) return 0.0;
  const double span_s = std::sqrt(12 * moments::mean_square_u(from.channel(c).instants, 2 * harmonics() + 1));
  const double in_period = std::max(1.0, fit.samples * std::min(1.0, period_s() / std::max(span_s, 1e-9)));
  return step / std::sqrt(12.0) * std::sqrt(2 / in_period);
}

ChannelResult Pipeline::Impl::result_of(int c, bool up_to_now, HarmonicFits& fits) const {
  const LiveChannel& channel = live[c];
  ChannelResult result;
  result.fit = fits.fit(c, blocks().reference(c));
  result.dof = result.fit.samples - (2 * harmonics() + 1);
  if (channel.stuck(period_s()))
    result.withheld = "stuck at one reading";
  else if (up_to_now && !delivers(c))
    result.withheld = channel.silent_reason();
  if (states.measuring() && windows.left_at_verdict(c) > 0 && std::isfinite(provisional_chain.time_constant_s())) {
    // Over the D that count, a decay with T has the mean T/D (1 - exp(-D/T)) of its beginning. Taken as rectangular.
    const double D = std::max(to_s(now_ns - at.settled_ns), 1e-9);
    const double u = windows.left_at_verdict(c) * provisional_chain.time_constant_s() / D *
                     -std::expm1(-D / provisional_chain.time_constant_s()) / std::numbers::sqrt3;
    result.transient = u * u * Eigen::Matrix2d::Identity();
  }
  if (states.measuring() && modes.removal().active() && result.fit.usable) {
    // Effect of the modes' amplitude errors on p_1 and q_1, turned to the phasor's reference instant.
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(modes.fit().angle(data.totals().t_ref_ns())).toRotationMatrix();
    result.transient = turn * modes.removal().covariance(c, result.fit.samples) * turn.transpose();
  }
  result.quantization_u = quantization_u(c, result.fit, data.totals());
  result.turnaround_u_s = channel.turnaround_u_s();
  result.transaction = live.transaction_of(c);
  return result;
}

void Pipeline::Impl::judge_readings(int c, ChannelResult& result) const {
  const HarmonicFit& fit = result.fit;
  if (!fit.usable || rig.channels[static_cast<std::size_t>(c)].measures == Quantity::auxiliary) return;
  result.refresh_u_s = live[c].intake().refresh_half_s() / std::numbers::sqrt3;
  if (states.measuring()) {
    result.uneven = {.part = kMeanOverScatter * errors_in_motion.part(c),
                     .own_s = kMeanOverScatter * errors_in_motion.own_s(c),
                     .shared_s = kMeanOverScatter * errors_in_motion.shared_s(c),
                     .with = errors_in_motion.with(c)};
  }
  if (!result.withheld.empty()) return;
  const double u = std::hypot(std::sqrt(0.5 * fit.covariance.trace()), result.quantization_u);
  result.withheld = live[c].unfit_reason(std::abs(fit.X[0]), u, states.measuring());
}

// Hum adds to a harmonic if its alias cannot be told from the harmonic within the dwell.
void Pipeline::Impl::warn_of_hum(double seconds, Dwell& dwell) const {
  const double f = omega() / kTwoPi;
  for (const double line : kMainsFundamentals_hz)
    for (int h = 1; h <= harmonics(); ++h) {
      std::vector<std::string> channels;
      std::string names;
      for (int c = 0; c < live.count(); ++c)
        if (live[c].sampling().distance_hz(line, h * f) < kMainsWander_hz + 1 / seconds) {
          channels.push_back(rig.channels[static_cast<std::size_t>(c)].name);
          names.append(names.empty() ? "" : ", ").append(channels.back());
        }
      if (names.empty()) continue;
      const std::string hertz = std::to_string(static_cast<int>(line));
      dwell.warnings.push_back({WarningKind::hum,
                                "hum of " + hertz + " Hz, if there is any, cannot be told from harmonic " +
                                    std::to_string(h) + " in " + names + ": choose another frequency or sampling rate",
                                {},
                                std::move(channels)});
    }
}

// What is known of the dwell without its data.
Dwell Pipeline::Impl::heading() const {
  Dwell dwell;
  dwell.state = states.state();
  dwell.memory_time_predicted_s = std::isfinite(provisional_chain.time_constant_s())
                                      ? -provisional_chain.time_constant_s() * std::log(rig.tolerance)
                                      : kNaN;
  dwell.settling_reason = settling_reason();
  if (at.origin_ns == INT64_MIN || states.at_rest()) return dwell;
  dwell.index = states.index();
  dwell.start_s = axis_s(at.start_ns);
  return dwell;
}

Pipeline::Impl::Evaluated Pipeline::Impl::evaluated(int to, bool with_open) const {
  int quarters_left = 0;
  for (int i = 0; i < to; ++i) quarters_left += blocks().block(i).quarters;
  Evaluated of;
  of.settled = states.measuring() && quarters_left >= kFewestQuarters;
  of.to = to;
  of.from = of.settled ? 0 : std::max(0, to - kQuarters * windows.length().periods());
  const std::int64_t begin_ns = of.from < blocks().count() ? blocks().block(of.from).begin_ns : now_ns;
  of.with_open = with_open;
  const bool to_now = with_open || to == 0;
  of.seconds = to_s((to_now ? now_ns : blocks().block(to - 1).end_ns) - begin_ns);
  of.last_ns = to_now ? at.last_sample_ns : std::min(at.last_sample_ns, blocks().block(to - 1).end_ns);
  return of;
}

std::vector<ChannelResult> Pipeline::Impl::channel_results(const Evaluated& of, bool up_to_now) const {
  std::vector<ChannelResult> results;
  HarmonicFits fits(data.totals(), harmonics());
  for (int c = 0; c < live.count(); ++c) {
    results.push_back(result_of(c, up_to_now, fits));
    if (out_of_search()) results.back().withheld = "the drive is outside the search range";
  }
  if (of.settled) look_within(of.from, of.to, of.seconds, fits, results);
  for (ChannelResult& result : results)
    for (int h = 1; h <= harmonics(); ++h)
      result.fit.X[static_cast<std::size_t>(h - 1)] *= std::polar(1.0, h * data.bend(data.totals().t_ref_ns()));
  return results;
}

// u: of ω by the fit of the table, rad/s. A table that is not steady, or read late by the refresh of its register,
// widens it; what is stated of the frequency bounds that.
double Pipeline::Impl::u_omega_of(double u, const ChannelResult& table, double seconds) const {
  if (!from_motion()) return u;
  u *= frequency_widens(table);
  return std::min(std::hypot(u, refresh_u_omega(seconds)), std::max(u, reference.stated().u));
}

// Widens the channels by what harmonics that are not fitted fold onto the fundamental, and warns of it.
void Pipeline::Impl::widen_by_folding(std::vector<ChannelResult>& results, double w, double seconds,
                                      Dwell& dwell) const {
  std::vector<Folded> folded;
  for (int c = 0; c < live.count(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    folded.push_back(folded_onto_fundamental(rig, rig.channels[i], live[c].sampling(), w / kTwoPi, seconds));
    results[i].folded_u = folded.back().part * std::abs(results[i].fit.X[0]) / std::numbers::sqrt3;
  }
  warn_of_folded(rig, folded, dwell);
}

void Pipeline::Impl::warn_of_readings(const std::vector<ChannelResult>& results, Dwell& dwell) const {
  for (int c = 0; c < live.count(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    const auto warn = [&](const std::string& of) {
      const std::string& name = rig.channels[i].name;
      dwell.warnings.push_back({WarningKind::readings, name + ": " + of, {}, {name}});
    };
    for (const std::string& warning : live[c].warnings(rig.tolerance)) warn(warning);
    for (const std::string& reason : uneven_reasons(c, results[i], dwell.phasors[i])) warn(reason);
    if (!(results[i].quantization_u > 0)) continue;  // noise smooths the steps of rounding
    if (const std::string reason = live[c].intake().coarse_reason(); !reason.empty()) warn(reason);
  }
}

// How the errors that grow with the motion show, in words, where they matter beside the phasor's other uncertainty.
std::vector<std::string> Pipeline::Impl::uneven_reasons(int c, const ChannelResult& result,
                                                        const ChannelPhasor& phasor) const {
  std::vector<std::string> reasons;
  const auto matters = [](double u, double all) {
    return u > kUnevenMatters * std::sqrt(std::max(0.0, all * all - u * u));
  };
  if (matters(omega() * result.uneven.own_s, phasor.u_phase_rad))
    reasons.push_back("its readings scatter most where it moves fastest, as if each were taken at a wrong time, " +
                      brief(1e3 * errors_in_motion.own_s(c), 2) +
                      " ms (rms). The mean delay may be wrong too: u includes " + brief(1e3 * result.uneven.own_s, 2) +
                      " ms for it. Check stamps, repeats and polling, and whether it is clipped");
  if (matters(result.uneven.part, phasor.u_amplitude / std::abs(phasor.Y)))
    reasons.push_back(
        "its readings scatter most at the turning points, as if the gain varied from reading to reading, by " +
        percent(errors_in_motion.part(c)) + " (rms). The mean gain may be wrong too: u includes " +
        percent(result.uneven.part) + " for it. Look for zeros, outliers, changes of range or wrong bytes");
  return reasons;
}

// A dwell without coefficients: says why, and how long it may last.
void Pipeline::Impl::tell_not_settled(Dwell& dwell) const {
  if (states.at_rest()) return;
  if (states.measuring()) {
    dwell.settling_reason =
        "too few data: the newest may have been taken while the drive changed; hold the drive longer";
    if (tracker.seen_swinging())
      dwell.settling_reason +=
          ". Seen: " + tracker.unsteady_reason(to_s(now_ns - at.armed_ns), live[drive_channel()].sampling());
  } else if (barred_reason().empty() && foreign_channel() < 0 &&
             verdict.settles_in_s <= kFarthest * to_s(now_ns - at.steady_ns)) {
    dwell.settles_in_s = verdict.settles_in_s;
  }
  dwell.warnings.push_back({WarningKind::not_settled, kNotSettled + dwell.settling_reason});
}

void Pipeline::Impl::tell_settled(Dwell& dwell) const {
  dwell.settled_s = axis_s(std::max(at.settled_ns, blocks().count() > 0 ? blocks().block(0).begin_ns : at.settled_ns));
  dwell.verdict_s = axis_s(at.verdict_ns);
  dwell.memory_time_s = axis_s(at.settled_ns) - axis_s(at.steady_ns);
  dwell.settles_in_s = 0.0;
  if (rig.mass_count() > 0 && std::isinf(provisional_chain.time_constant_s()) && !modes.removal().active())
    dwell.warnings.push_back({WarningKind::growing_chain,
                              "the chain identified while settling has oscillations that grow: the windows alone "
                              "judged the transient; check "
                              "signs, instants and masses"});
  if (std::string missed = reference.missed(); !missed.empty())
    dwell.warnings.push_back({WarningKind::sync_pulses, std::move(missed)});
}

DwellDraft Pipeline::Impl::draft(int to, bool with_open, bool up_to_now) const {
  Dwell dwell = heading();
  if (at.origin_ns == INT64_MIN) return DwellDraft(std::move(dwell));
  const Evaluated of = evaluated(to, with_open);
  const Refined refined = data.gather(of.from, of.to, of.with_open, now_ns, at.steady_ns);
  dwell.t_ref_s = axis_s(data.totals().t_ref_ns());
  dwell.end_s = axis_s(of.last_ns);
  const double w = data.omega_at(data.totals().t_ref_ns(), refined.omega);  // in the middle of the data
  std::vector<ChannelResult> results = channel_results(of, up_to_now);
  const ChannelResult& table = results[static_cast<std::size_t>(drive_channel())];
  double u = refined.u;
  if (of.settled) {
    look_at_settling(results);
    warn_of_change(results, of.seconds, dwell);
    u = u_omega_of(u, table, of.seconds);
  }
  for (int c = 0; c < live.count(); ++c) judge_readings(c, results[static_cast<std::size_t>(c)]);
  if (of.settled) widen_by_folding(results, w, of.seconds, dwell);
  // The frequency of a drifting drive is not one: its spread over the dwell is added.
  report_phasors(rig, results, w, std::hypot(u, data.drift().rate * of.seconds / std::sqrt(12.0)), dwell);
  if (states.at_rest() || out_of_search()) dwell.frequency_hz = {};
  warn_of_readings(results, dwell);
  if (!of.settled) {
    tell_not_settled(dwell);
    return DwellDraft(std::move(dwell));
  }
  tell_settled(dwell);
  if (const std::string reason = reference.unfit_reason(refined, table.fit, w, u, refresh_u_omega(of.seconds));
      !reason.empty()) {
    dwell.settling_reason = reason;
    dwell.warnings.push_back({WarningKind::no_coefficients, "no coefficients: " + reason});
    return DwellDraft(std::move(dwell));
  }
  warn_of_hum(std::max(dwell.end_s - dwell.settled_s, period_s()), dwell);
  const auto seen = modes.modes();
  return {std::move(dwell), {&rig, &G, std::move(results), w, u, {seen.begin(), seen.end()}}};
}

Dwell Pipeline::Impl::evaluate(int to, bool with_open, bool up_to_now) const {
  return draft(to, with_open, up_to_now).finish();
}

}  // namespace dwell
