// Tells by the jump after a repeat whether a gateway repeated its answer or a register was not refreshed yet.
//
// The reading after a repeated answer is up to date, so the motion catches up: r identical readings are followed by a
// jump r times as large as those around them. The next value of a register is one refresh later, and jumps no farther
// than any other. Take the jump after the run, per reading of the run, over the mean of the jumps around it. This ratio
// is 1 for repeated answers and 1/2 for a register. (Seen in 50 registers each, refreshed every 1.004 … 1.16 readings:
// at most 0.6 where refreshes jitter by ± 0.3 readings; 0.76 by ± 0.8. In repeated answers 0.9 … 1.4, noise up to a
// quarter of the steepest jump.) With noise as large as the jumps the ratio falls towards 0: then a register is
// assumed.
#pragma once

#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe. O(1) per call.
class RepeatCatchUp {
 public:
  // run: length of the run, readings. before, after, next: the jump before the run, the one after it, and the one after
  // that. mean: mean size of all jumps. All jumps are in units of the device. Only a steep motion counts: elsewhere the
  // sign of noise would pass for a direction.
  void add(std::int64_t run, double before, double after, double next, double mean) noexcept {
    const double moved = before + after + next;
    if (!(std::abs(moved) > kSteep * mean)) return;
    if (++jumps_ > kRemembered) jumps_ /= 2, caught_ /= 2, around_ /= 2;
    caught_ += std::copysign(1.0, moved) * after / static_cast<double>(run);
    around_ += std::copysign(0.5, moved) * (before + next);
  }

  // Whether the motion catches up, as after repeated answers.
  [[nodiscard]] bool shown() const noexcept { return jumps_ >= kFewest && caught_ >= kCaughtUp * around_; }
  // Whether further jumps may still show it.
  [[nodiscard]] bool possible() const noexcept { return jumps_ < kFewest || caught_ >= kUnclear * around_; }

 private:
  static constexpr double kSteep = 3.0;                      // mean jumps, by which three jumps move
  static constexpr double kCaughtUp = 0.75, kUnclear = 0.6;  // 1: repeated answers; 1/2: a register
  static constexpr int kFewest = 4, kRemembered = 256;       // jumps

  int jumps_ = 0;
  double caught_ = 0.0, around_ = 0.0;  // sums over these: the jump after a run, per reading of it; the jumps around
};

}  // namespace dwell
