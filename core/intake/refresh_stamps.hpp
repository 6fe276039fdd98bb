// Gives each new value of a held register the instant of its refresh.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/intake/motion_gate.hpp"
#include "core/intake/refresh_clock.hpp"

namespace dwell {

// Of one channel. Bound to one thread; real-time safe.
class RefreshStamps {
 public:
  // A new value was read at reading.t_ns. take() moves the clock on if the value counts. hold: the register is held,
  // and the reading gets the instant of its refresh.
  void date(MotionGate::Reading& reading, bool hold) noexcept {
    if (old_seen_ns_ == INT64_MIN) return;
    if_taken_ = clock_;
    dated_ = true;
    const RefreshClock::Instant instant = if_taken_.refreshed(old_seen_ns_, reading.t_ns);
    if (!hold) return;
    reading.t_ns = std::max(instant.t_ns, dated_ns_ + 1);
    reading.refresh_half_ns = instant.half_ns;
  }
  // Another reading comes: a value dated but not taken is forgotten.
  void next() noexcept { dated_ = false; }
  // At read_ns a reading was taken, or showed the old value again.
  void see_old(std::int64_t read_ns) noexcept { old_seen_ns_ = read_ns; }
  // A reading may count at t_ns: later ones get later instants.
  void keep_order(std::int64_t t_ns) noexcept { dated_ns_ = t_ns; }
  // Values that count and have not waited, of a register that is not held; the last was read at last_ns.
  void take_plain(std::int64_t last_ns) noexcept {
    dated_ = false;
    dated_ns_ = old_seen_ns_ = last_ns;
  }
  // The newest value counts. half_ns: half width of its refresh; below 0: the register is not held.
  void take(double half_ns) noexcept {
    if (dated_) clock_ = if_taken_;
    if (half_ns >= 0) half_ns_ += half_ns, refreshes_ += 1, widest_ns_ = std::max(widest_ns_, half_ns);
  }
  // Mean half width of the instants since the restart, s; 0: there are none.
  [[nodiscard]] double half_s() const noexcept { return refreshes_ > 0 ? 1e-9 * half_ns_ / refreshes_ : 0.0; }
  // The largest of them, s: the first, as a rule, when only two readings bound the refresh. 0: there are none.
  [[nodiscard]] double widest_s() const noexcept { return 1e-9 * widest_ns_; }
  void restart() noexcept { half_ns_ = refreshes_ = widest_ns_ = 0.0; }

 private:
  RefreshClock clock_, if_taken_;
  bool dated_ = false;  // if_taken_ becomes the clock if the newest reading counts
  std::int64_t old_seen_ns_ = INT64_MIN, dated_ns_ = INT64_MIN;
  double half_ns_ = 0.0, refreshes_ = 0.0, widest_ns_ = 0.0;  // sum, ns; number; largest, ns
};

}  // namespace dwell
