// Gives the values of a held register the instants of their refreshes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/intake/motion_gate.hpp"
#include "core/intake/refresh_clock.hpp"

namespace dwell {

// Of one channel. Bound to one thread; real-time safe.
class RefreshStamps {
 public:
  // What the clock knows if this new value, read at reading.t_ns, counts. hold: the register is held, and the reading
  // gets the instant of its refresh. The caller gives the clock back with take(), or forgets it.
  RefreshClock date(MotionGate::Reading& reading, bool hold) const noexcept {
    RefreshClock clock = clock_;
    if (old_seen_ns_ == INT64_MIN) return clock;
    const RefreshClock::Instant instant = clock.refreshed(old_seen_ns_, reading.t_ns);
    if (!hold) return clock;
    reading.t_ns = std::max(instant.t_ns, dated_ns_ + 1);
    reading.refresh_half_ns = instant.half_ns;
    return clock;
  }
  [[nodiscard]] const RefreshClock& clock() const noexcept { return clock_; }
  // At read_ns a reading was taken, or showed again what was there.
  void see_old(std::int64_t read_ns) noexcept { old_seen_ns_ = read_ns; }
  // A reading may count at that instant: those to come are later.
  void keep_order(std::int64_t t_ns) noexcept { dated_ns_ = t_ns; }
  // The value counts; half_ns: of its refresh, below 0: the register is not held.
  void take(const RefreshClock& clock, double half_ns) noexcept {
    clock_ = clock;
    if (half_ns >= 0) half_ns_ += half_ns, refreshes_ += 1;
  }
  // Half width to which the instants are known, mean since the restart, s; 0: there are none.
  [[nodiscard]] double half_s() const noexcept { return refreshes_ > 0 ? 1e-9 * half_ns_ / refreshes_ : 0.0; }
  void restart() noexcept { half_ns_ = refreshes_ = 0.0; }

 private:
  RefreshClock clock_;
  std::int64_t old_seen_ns_ = INT64_MIN, dated_ns_ = INT64_MIN;
  double half_ns_ = 0.0, refreshes_ = 0.0;  // sum, number
};

}  // namespace dwell
