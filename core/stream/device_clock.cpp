#include "core/stream/device_clock.hpp"

#include <algorithm>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

constexpr double kSilentPeriods = 64.0;

}  // namespace

DeviceClock::DeviceClock(double nominal_rate_hz) noexcept
    : search_(nominal_rate_hz > 0.0 ? kNsPerS / nominal_rate_hz : 0.0) {}

void DeviceClock::arrive(std::int64_t arrival_ns) noexcept {
  if (any_) {
    arrival_ns = std::max(arrival_ns, last_arrival_ns_);
    const double silence_ns = std::max(kNsPerS * kSilent_s, kSilentPeriods * tracker_.period_ns());
    if (locked_ && static_cast<double>(arrival_ns - last_arrival_ns_) > silence_ns) unlock();
  }
  any_ = true;
  last_arrival_ns_ = arrival_ns;
  if (held_.full()) decide_all();
  if (Instant untaken; held_.full()) held_.take(untaken);  // only if the caller does not take what is decided
  held_.add(arrival_ns);
  if (!locked_) {
    held_.decide(stamps_.arrived(arrival_ns));
    if (const auto grid = search_.add(arrival_ns)) lock(*grid);
    return;
  }
  weigh(false);
  if (locked_ && tracker_.doubts_nominal()) {
    search_.forget_nominal();
    unlock();
  }
}

void DeviceClock::wait(std::int64_t now_ns) noexcept {
  if (held_.waiting() > 0 && now_ns - held_.arrival_ns(0) > kLongestHold_ns) weigh(true);
}

void DeviceClock::decide_all() noexcept {
  if (held_.waiting() > 0) weigh(true);
}

ClockFigures DeviceClock::figures() const noexcept {
  ClockFigures figures;
  figures.lost = lost_;
  figures.relocked = relocked_;
  figures.locked = locked_;
  if (!locked_) return figures;
  figures.rate_hz = kNsPerS / tracker_.period_ns();
  figures.jitter_s = tracker_.jitter_ns() / kNsPerS;
  return figures;
}

void DeviceClock::weigh(bool at_once) noexcept {
  while (held_.waiting() > 0) {
    const LossJudge::Verdict verdict = judge_.judge(held_, tracker_, at_once);
    if (verdict.settled == 0 && verdict.lost == 0) return;
    commit(verdict.settled);
    if (verdict.lost == 0) continue;
    tracker_.shift(verdict.lost);
    judge_.count(verdict.lost);
    if (verdict.lost > 0) {
      lost_ += static_cast<std::uint64_t>(verdict.lost);
      stamps_.lost();
    } else {
      lost_ -= std::min<std::uint64_t>(lost_, static_cast<std::uint64_t>(-verdict.lost));
      stamps_.doubt(-verdict.lost);
    }
    if (judge_.implausible()) {
      search_.forget_nominal();
      unlock();
      return;
    }
  }
}

void DeviceClock::commit(std::size_t count) noexcept {
  for (; count > 0; --count) {
    const std::int64_t arrival_ns = held_.arrival_ns(0);
    judge_.learn(arrival_ns, tracker_.follow(arrival_ns));
    held_.decide(stamps_.recovered(tracker_.t_ns(), tracker_.half_ns(), tracker_.period_ns()));
  }
}

void DeviceClock::lock(const ArrivalGrid& grid) noexcept {
  locked_ = true;
  tracker_.begin(grid, search_.begin_ns(), search_.count(), search_.nominal_ns());
  judge_.begin(grid, last_arrival_ns_);
  stamps_.begin();
}

// Readings held get their arrivals as stamps; the search for the clock begins again.
void DeviceClock::unlock() noexcept {
  while (held_.waiting() > 0) held_.decide(stamps_.arrived(held_.arrival_ns(0)));
  locked_ = false;
  ++relocked_;
  search_.restart();
}

}  // namespace dwell
