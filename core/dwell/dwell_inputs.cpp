// The inputs of a dwell beside the samples: the edges of interlock and sync input. Also the check of the drive's
// frequency against the rig file's (reference = "fixed"). If they contradict, nothing is reported: the statement or the
// clock is wrong, and each coefficient depends on the square of the frequency.
#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kShortestHeld = 2 * kQuarters;  // quarters of a hold before its frequency is compared with the stated one
constexpr int kNewtonSteps = 4;               // of Gauss-Newton, from the windows' own frequency

}  // namespace

void Pipeline::Impl::edge(const Record& record) {
  const bool active = record.value > 0.5;
  if (record.channel == static_cast<std::uint16_t>(Line::sync)) {
    if (active && !(record.flags & kStampReplaced)) reference.pulse(record.t_ns);
    return;
  }
  if (record.channel != static_cast<std::uint16_t>(Line::interlock)) return;
  // Edges lost before this one may have opened the interlock.
  const bool lost = !active || (record.flags & kGap) != 0;
  const bool was_open = states.interlocked();
  if (!was_open && lost) {
    end(EndedBy::interlock, false);
    data.forget_omega();
  }
  if (active && (was_open || lost)) {
    data.close();
    data.clear();
    data.open(record.t_ns);
  }
  states.interlock(active);
}

// Uses the table alone, in the newest quarters that were never joined: these resolve parts in a million.
std::optional<double> Pipeline::Impl::contradicting_omega() const {
  if (!reference.stated().stated() || !states.settling() || !std::isfinite(tracker.omega())) return {};
  const int to = blocks().count();
  const int from = std::max(blocks().index_of(at.steady_serial + static_cast<std::int64_t>(kUnsure * kQuarters)),
                            to - Blocks::kFine);
  if (to - from < kShortestHeld) return {};
  const std::int64_t middle_ns =
      blocks().block(from).begin_ns + (blocks().block(to - 1).end_ns - blocks().block(from).begin_ns) / 2;
  double w = tracker.omega(), information = 0.0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const HarmonicFit fit = data.fit(drive_channel(), from, to, w, middle_ns);
    if (!(fit.information > 0)) return {};
    information = fit.information;
    w += fit.score / fit.information;
  }
  const double by_refresh = refresh_u_omega(to_s(blocks().block(to - 1).end_ns - blocks().block(from).begin_ns));
  if (!reference.stated().contradicted(w, std::hypot(1 / std::sqrt(information), by_refresh))) return {};
  return w;
}

}  // namespace dwell
