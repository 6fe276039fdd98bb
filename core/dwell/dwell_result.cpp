#include <Eigen/Geometry>

#include "core/base/wording.hpp"
#include "core/dwell/pipeline_impl.hpp"
#include "core/fit/drive_harmonic.hpp"
#include "core/fit/folded.hpp"

namespace dwell {
namespace {

constexpr int kManyRestarts = 6;  // of a hold in a row: these need an explanation
// Periods after the drive's channel was last found not to deliver. By then the quarter of a period that the loss cut
// short is over, and the window of two periods holds its full number of readings.
constexpr double kPeriodsToReturn = 2.5;
// Parts of the drive's frequency within which a line is called its harmonic. Any line lies so near one of them by
// chance in one of 50 cases.
constexpr double kAtHarmonic = 0.01;
// Longest time left that is stated, in times watched so far. The time left is extrapolated from the decay seen so far.
// If it is so long, the slowest oscillation has lost a few percent of its size at most. Noise and a wrong pole look
// like that even if nothing decays. Halved: slow rigs go without a time for longer. Doubled: more times that mean
// nothing.
constexpr double kFarthest = 100.0;
// Largest part of a channel's readings that may be left out as foreign while a time left is stated. Above it, some
// foreign readings pass the gates and are fitted as a transient, and all channels share its poles. A float32 in the
// wrong order of words has 6 to 9 % left out. A gateway's zeros are at most 2 % where the poles are still right.
// Halved, it comes near those zeros. Doubled, it misses the float32.
constexpr double kMostForeign = 0.05;

double foreign_part(const LiveChannels& live, const Rig& rig) {
  double most = 0.0;
  for (int c = 0; c < live.count(); ++c)
    if (rig.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary)
      most = std::max(most, live[c].intake().left_out());
  return most;
}

}  // namespace

std::string Pipeline::Impl::foreign_oscillations() const {
  std::string lines;
  for (const Complex pole : modes.poles().beside) {
    if (!(pole.imag() > 0)) continue;
    lines += (lines.empty() ? "; an oscillation that is not the chain's, at " : " and at ") +
             std::to_string(pole.imag() / kTwoPi).substr(0, 5) + " Hz";
    const double w = tracker.omega();
    if (const int m = unfitted_harmonic(pole.imag(), w, kAtHarmonic * w, harmonics()); m > 0)
      lines += " (harmonic " + std::to_string(m) + " of the drive: excitation.harmonics leaves it out)";
  }
  return lines;
}

// While the drive's channel is lost, and shortly after, the newest window holds few of its readings. That must not be
// reported as too low a sampling rate.
std::string Pipeline::Impl::unseen_reason() const {
  if (states.state() != State::fault) return "";
  const std::string& name = rig.channels[static_cast<std::size_t>(drive_channel())].name;
  if (!delivers(drive_channel())) return "the drive is not seen: " + name + " is " + live[drive_channel()].fault_name();
  if (at.lost_ns != INT64_MIN && to_s(now_ns - at.lost_ns) < kPeriodsToReturn * period_s())
    return "the drive is not seen yet: " + name + " delivers again, its first periods are awaited";
  return "";
}

std::string Pipeline::Impl::barred_reason() const {
  if (std::string reason = unseen_reason(); !reason.empty()) return reason;
  if (windows.length().too_few() && !states.measuring())
    return rig.channels[static_cast<std::size_t>(drive_channel())].name + " has too few samples a period for " +
           std::to_string(harmonics()) + " harmonics: at least " + std::to_string(2 * (harmonics() + 1)) +
           " are needed" +
           (live[drive_channel()].intake().held() ? "; it is " + live[drive_channel()].intake().held_reason() : "");
  if (states.phase() == Phase::interlocked) return "the interlock is open";
  if (states.phase() == Phase::idle) return tracker.at_rest_reason();
  if (delivers(drive_channel())) {
    if (std::string reason = reference.unusable_reason(now_ns); !reason.empty()) return reason;
    if (states.settling() && reference.pulses_contradict(tracker.omega()))
      return reference.contradiction_of_pulses(tracker.omega());
  }
  if (states.state() == State::fault)
    return "the drive is not seen yet in " + rig.channels[static_cast<std::size_t>(drive_channel())].name;
  if (out_of_search())
    return "the drive is at " + brief(tracker.omega() / kTwoPi, 6) + " Hz, outside the search range of " +
           brief(rig.excitation.search_low_hz, 6) + " to " + brief(rig.excitation.search_high_hz, 6) +
           " Hz (excitation.search)";
  if (const auto other = contradicting_omega()) return reference.contradiction_of_statement(*other);
  if (states.settling() && states.restarts() >= kManyRestarts)
    return tracker.unsteady_reason(to_s(now_ns - at.armed_ns));
  return "";
}

// Names the settled data that do not count, and why.
std::string Pipeline::Impl::left_out_of_dwell() const {
  if (!states.measuring() || blocks().count() == 0) return "";
  const std::int64_t from_ns = blocks().block(0).begin_ns;
  const double left_s = to_s(from_ns - at.settled_ns),
               kept_s = to_s(blocks().block(blocks().count() - 1).end_ns - from_ns);
  if (!(left_s > period_s() / kQuarters)) return "";
  if (left_s + kept_s > rig.memory_s)
    return "; only the newest " + brief(kept_s) + " s count (estimation memory = " + brief(rig.memory_s) + ")";
  return "; the first " + brief(left_s, 2) + " s do not count: the drive's frequency was not known yet";
}

std::string Pipeline::Impl::settling_reason() const {
  if (std::string reason = barred_reason(); !reason.empty()) return reason;
  if (states.settling()) {
    if (states.unconfirmed())
      return "the transient seems to be over, but readings are rounded: more data must confirm it";
    if (verdict.worst_channel >= 0 && verdict.worst_left > 1 && std::isfinite(verdict.worst_left)) {
      const std::string times = std::to_string(verdict.worst_left);
      return taken_back_reason() + "transient left in " +
             rig.channels[static_cast<std::size_t>(verdict.worst_channel)].name + ": " +
             times.substr(0, times.find('.') + 2) + " times the allowed size" +
             (rig.mass_count() > 0 && !std::isfinite(provisional_chain.time_constant_s()) &&
                      blocks().serials() - at.steady_serial > 10 * kQuarters
                  ? "; the coefficients so far give a chain whose oscillations grow: check signs, channel order and "
                    "masses"
                  : "") +
             (live[verdict.worst_channel].intake().held()
                  ? ", which is " + live[verdict.worst_channel].intake().held_reason()
                  : foreign_oscillations());
    }
    if (states.restarts() > 0) return tracker.unsteady_reason(to_s(now_ns - at.armed_ns));
    return "too few periods seen: " + brief(to_s(now_ns - at.steady_ns) / period_s(), 2);
  }
  const std::string since = brief(axis_s(at.settled_ns), 4) + " s";
  return (modes.removal().active() ? "since " + since + " the natural oscillations are below the allowed size"
                                   : "the windows since " + since + " agree") +
         left_out_of_dwell();
}

// Text before the reason why the rig settles again; empty: no verdict was taken back.
std::string Pipeline::Impl::taken_back_reason() const {
  const auto& taken_back = modes.taken_back();
  if (!taken_back) return "";
  return "the verdict at " + brief(axis_s(taken_back->verdict_ns), 4) +
         " s was premature and is taken back: the transient in " +
         rig.channels[static_cast<std::size_t>(taken_back->channel)].name + " was " + brief(taken_back->left, 2) +
         " times the allowed size; ";
}

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

DwellDraft Pipeline::Impl::draft(int to, bool with_open, bool up_to_now) const {
  Dwell dwell;
  dwell.state = states.state();
  dwell.memory_time_predicted_s = std::isfinite(provisional_chain.time_constant_s())
                                      ? -provisional_chain.time_constant_s() * std::log(rig.tolerance)
                                      : kNaN;
  dwell.settling_reason = settling_reason();
  if (at.origin_ns == INT64_MIN) return DwellDraft(std::move(dwell));
  const bool active = !states.at_rest();
  if (active) {
    dwell.index = states.index();
    dwell.start_s = axis_s(at.start_ns);
  }
  int quarters_left = 0;
  for (int i = 0; i < to; ++i) quarters_left += blocks().block(i).quarters;
  const bool settled = states.measuring() && quarters_left >= kFewestQuarters;
  const int from = settled ? 0 : std::max(0, to - kQuarters * windows.length().periods());
  const Refined refined = data.gather(from, to, with_open, now_ns, at.steady_ns);
  // ω in the middle of the data.
  const double w = data.omega_at(data.totals().t_ref_ns(), refined.omega);
  dwell.t_ref_s = axis_s(data.totals().t_ref_ns());
  std::vector<ChannelResult> results;
  HarmonicFits fits(data.totals(), harmonics());
  for (int c = 0; c < live.count(); ++c) {
    results.push_back(result_of(c, up_to_now, fits));
    if (out_of_search()) results.back().withheld = "the drive is outside the search range";
  }
  const double seconds = to_s((with_open || to == 0 ? now_ns : blocks().block(to - 1).end_ns) -
                              (from < blocks().count() ? blocks().block(from).begin_ns : now_ns));
  if (settled) look_within(from, to, seconds, fits, results);
  for (ChannelResult& result : results)
    for (int h = 1; h <= harmonics(); ++h)
      result.fit.X[static_cast<std::size_t>(h - 1)] *= std::polar(1.0, h * data.bend(data.totals().t_ref_ns()));
  double u = refined.u;
  if (settled) {
    look_at_settling(results);
    warn_of_change(results, seconds, dwell);
    if (from_motion()) u *= frequency_widens(results[static_cast<std::size_t>(drive_channel())]);
    if (from_motion()) u = std::min(std::hypot(u, refresh_u_omega(seconds)), std::max(u, reference.stated().u));
  }
  for (int c = 0; c < live.count(); ++c) judge_readings(c, results[static_cast<std::size_t>(c)]);
  if (settled) {
    std::vector<Folded> folded;
    for (int c = 0; c < live.count(); ++c) {
      const auto i = static_cast<std::size_t>(c);
      folded.push_back(folded_onto_fundamental(rig, rig.channels[i], live[c].sampling(), w / kTwoPi, seconds));
      results[i].folded_u = folded.back().part * std::abs(results[i].fit.X[0]) / std::numbers::sqrt3;
    }
    warn_of_folded(rig, folded, dwell);
  }
  // The frequency of a drifting drive is not one: its spread over the dwell is added.
  report_phasors(rig, results, w, std::hypot(u, data.drift().rate * seconds / std::sqrt(12.0)), dwell);
  if (!active || out_of_search()) dwell.frequency_hz = {};
  dwell.end_s =
      axis_s(with_open || to == 0 ? at.last_sample_ns : std::min(at.last_sample_ns, blocks().block(to - 1).end_ns));
  for (int c = 0; c < live.count(); ++c) {
    const auto warn = [&](const std::string& of) {
      const std::string& name = rig.channels[static_cast<std::size_t>(c)].name;
      dwell.warnings.push_back({WarningKind::readings, name + ": " + of, {}, {name}});
    };
    for (const std::string& warning : live[c].warnings(rig.tolerance)) warn(warning);
    if (!(results[static_cast<std::size_t>(c)].quantization_u > 0)) continue;  // noise smooths the steps of rounding
    if (const std::string reason = live[c].intake().coarse_reason(); !reason.empty()) warn(reason);
  }
  if (!settled) {
    if (states.measuring()) {
      dwell.settling_reason =
          "too few data: the newest may have been taken while the drive changed; hold the drive longer";
      dwell.warnings.push_back({WarningKind::not_settled, kNotSettled + dwell.settling_reason});
    } else if (active) {
      if (barred_reason().empty() && !(foreign_part(live, rig) > kMostForeign) &&
          verdict.settles_in_s <= kFarthest * to_s(now_ns - at.steady_ns))
        dwell.settles_in_s = verdict.settles_in_s;
      dwell.warnings.push_back({WarningKind::not_settled, kNotSettled + dwell.settling_reason});
    }
    return DwellDraft(std::move(dwell));
  }
  dwell.settled_s = axis_s(std::max(at.settled_ns, blocks().count() > 0 ? blocks().block(0).begin_ns : at.settled_ns));
  dwell.verdict_s = axis_s(at.verdict_ns);
  dwell.memory_time_s = axis_s(at.settled_ns) - axis_s(at.steady_ns);
  dwell.settles_in_s = 0.0;
  if (rig.mass_count() > 0 && !std::isfinite(provisional_chain.time_constant_s()) && !modes.removal().active())
    dwell.warnings.push_back({WarningKind::growing_chain,
                              "the chain identified while settling has oscillations that grow: the windows alone "
                              "judged the transient; check "
                              "signs, instants and masses"});
  if (std::string missed = reference.missed(); !missed.empty())
    dwell.warnings.push_back({WarningKind::sync_pulses, std::move(missed)});
  const std::string reason = reference.unfit_reason(refined, results[static_cast<std::size_t>(drive_channel())].fit, w,
                                                    u, refresh_u_omega(seconds));
  if (!reason.empty()) {
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
