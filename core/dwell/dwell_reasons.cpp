#include "core/base/wording.hpp"
#include "core/dwell/pipeline_impl.hpp"
#include "core/fit/drive_harmonic.hpp"

namespace dwell {
namespace {

// Largest part of a channel's readings that may be left out as foreign. Above it, some foreign readings pass the gates
// and are fitted as a transient, and all channels share its poles. A float32 in the wrong order of words has 6 to 9 %
// left out. A gateway's zeros are at most 2 % where the poles are still right. Halved, it comes near those zeros.
// Doubled, it misses the float32.
constexpr double kMostForeign = 0.05;
constexpr int kManyRestarts = 6;  // of a hold in a row: these need an explanation
// Periods after the drive's channel was last found not to deliver. By then the quarter of a period that the loss cut
// short is over, and the window of two periods holds its full number of readings.
constexpr double kPeriodsToReturn = 2.5;
// Parts of the drive's frequency within which a line is called its harmonic. Any line lies so near one of them by
// chance in one of 50 cases.
constexpr double kAtHarmonic = 0.01;

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
  const LiveChannel& drive = live[drive_channel()];
  if (!delivers(drive_channel())) return "the drive is not seen: " + name + " is " + drive.fault_name();
  if (drive.stuck(period_s())) return "the drive is not seen: " + name + " is " + drive.condition_reason(period_s());
  if (at.lost_ns != INT64_MIN && to_s(now_ns - at.lost_ns) < kPeriodsToReturn * period_s())
    return "the drive is not seen yet: " + name + " delivers again, its first periods are awaited";
  return "";
}

// A table at rest may read one and the same value without noise, and so does a channel that is stuck.
std::string Pipeline::Impl::at_rest_reason() const {
  const LiveChannel& drive = live[drive_channel()];
  if (!drive.stuck(period_s())) return tracker.at_rest_reason();
  return "the table does not move, or " + rig.channels[static_cast<std::size_t>(drive_channel())].name + " is " +
         drive.condition_reason(period_s());
}

std::string Pipeline::Impl::barred_reason() const {
  if (std::string reason = unseen_reason(); !reason.empty()) return reason;
  if (windows.length().too_few() && !states.measuring())
    return rig.channels[static_cast<std::size_t>(drive_channel())].name + " has too few samples a period for " +
           std::to_string(harmonics()) + " harmonics: at least " + std::to_string(2 * (harmonics() + 1)) +
           " are needed" +
           (live[drive_channel()].intake().held() ? "; it is " + live[drive_channel()].intake().held_reason() : "");
  if (states.phase() == Phase::interlocked) return "the interlock is open";
  if (states.phase() == Phase::idle) return at_rest_reason();
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
    return tracker.unsteady_reason(to_s(now_ns - at.armed_ns), live[drive_channel()].sampling());
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

int Pipeline::Impl::foreign_channel() const {
  for (int c = 0; c < live.count(); ++c)
    if (rig.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary &&
        live[c].intake().left_out() > kMostForeign)
      return c;
  return -1;
}

std::string Pipeline::Impl::settling_reason() const {
  if (std::string reason = barred_reason(); !reason.empty()) return reason;
  if (states.settling()) {
    if (states.unconfirmed())
      return "the transient seems to be over, but readings are rounded: more data must confirm it";
    if (verdict.worst_channel >= 0 && verdict.worst_left > 1 && std::isfinite(verdict.worst_left)) {
      if (const int c = foreign_channel(); c >= 0)
        return percent(live[c].intake().left_out()) + " of the readings of " +
               rig.channels[static_cast<std::size_t>(c)].name +
               " are beyond its range or far from all others: check the transducer, its data type and word order";
      const std::string times = std::to_string(verdict.worst_left);
      return taken_back_reason() + "transient left in " +
             rig.channels[static_cast<std::size_t>(verdict.worst_channel)].name + ": up to " +
             times.substr(0, times.find('.') + 2) + " times the allowed size" +
             (rig.mass_count() > 0 && std::isinf(provisional_chain.time_constant_s()) &&
                      blocks().serials() - at.steady_serial > 10 * kQuarters
                  ? "; the coefficients so far give a chain whose oscillations grow: check signs, channel order and "
                    "masses"
                  : "") +
             (live[verdict.worst_channel].intake().held()
                  ? ", which is " + live[verdict.worst_channel].intake().held_reason()
                  : foreign_oscillations());
    }
    if (states.restarts() > 0)
      return tracker.unsteady_reason(to_s(now_ns - at.armed_ns), live[drive_channel()].sampling());
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

}  // namespace dwell
