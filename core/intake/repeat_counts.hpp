// Counts the readings of a hold that repeat the one before, and how many of them chance brings.
//
// The differences of a smooth motion with noise have a density near 0 that no rounding resolves: differences of 0 are
// as frequent as those of one step up, and of one step down. The step is the third smallest difference seen; a second
// rounding never makes it smaller than the device's own. So half of the differences within 1.5 steps are expected. Some
// densities rise towards 0, so kDensity of all changes times the step over the mean jump is added. (A sine has 0.20,
// Gaussian noise 0.32, a decaying sine up to 0.5.) beyond_chance() judges.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/intake/recurring_numbers.hpp"
#include "core/intake/small_differences.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RepeatCounts {
 public:
  static constexpr double kDensity = 0.5;

  // Another reading. It equals the one before, or differs from it by `size`.
  void next() noexcept { ++pairs_; }
  void repeats_one_before() noexcept { ++same_; }
  void differs(double size) noexcept {
    path_ += size;
    differences_.add(size);
  }
  // A run of identical readings has interrupted the motion. The k-th such run counts for k readings at most: a channel
  // that was stuck for some seconds interrupts the motion once, a held register again and again.
  void interrupted(std::int64_t run) noexcept { interrupting_ += std::min(run - 1, ++interruptions_); }
  void restart() noexcept { *this = {}; }

  [[nodiscard]] std::int64_t pairs() const noexcept { return pairs_; }
  [[nodiscard]] std::int64_t changes() const noexcept { return pairs_ - same_; }
  [[nodiscard]] std::int64_t repeats() const noexcept { return same_; }
  [[nodiscard]] std::int64_t interruptions() const noexcept { return interruptions_; }
  [[nodiscard]] bool interrupts() const noexcept { return interrupting_ > 0; }
  [[nodiscard]] bool step_known() const noexcept { return changes() >= 3; }
  // Mean difference of two consecutive readings; 0: not known.
  [[nodiscard]] double mean_difference() const noexcept {
    return pairs_ > 0 ? path_ / static_cast<double>(pairs_) : 0.0;
  }
  // The third smallest difference above 0, at least the rounding step; INFINITY: not known.
  [[nodiscard]] double step() const noexcept { return differences_.step(); }
  [[nodiscard]] double least_difference() const noexcept { return differences_.least(); }

  // Differences expected within half a step of 0, or of any other size that is small against the mean.
  [[nodiscard]] double by_chance() const noexcept {
    const auto differing = static_cast<double>(changes());
    return kDensity * differing * differing * step() / path_;
  }
  // Whether more readings interrupt the motion than chance explains.
  [[nodiscard]] bool interrupts_beyond_chance() const noexcept {
    return beyond_chance(interrupting_, 0.5 * static_cast<double>(differences_.one_step()) + by_chance());
  }
  // Whether after so many pairs hardly a reading interrupts the motion.
  [[nodiscard]] bool hardly_interrupts() const noexcept { return pairs_ >= kEnough && interrupting_ < kHardlyAny; }
  // Whether chance explains too large a part of the repeats to leave them out.
  [[nodiscard]] bool mostly_by_chance() const noexcept {
    return kFewByChance * by_chance() > static_cast<double>(same_) + kTooFewToTell;
  }
  // Whether a flaky gateway may have brought the repeats, by their number.
  [[nodiscard]] bool few() const noexcept {
    return static_cast<double>(same_) <= kMostRandom * static_cast<double>(pairs_);
  }
  // Whether so many readings repeat the one before that no flaky gateway explains it.
  [[nodiscard]] bool many() const noexcept {
    const auto same = static_cast<double>(same_);
    return same > kMostRandom * static_cast<double>(pairs_) + 2 * std::sqrt(same);
  }

 private:
  // After kEnough pairs of readings with fewer than kHardlyAny interrupting ones, the register is not held.
  static constexpr std::int64_t kEnough = 4096, kHardlyAny = 8;
  // Largest part of the readings that a gateway may repeat at random, so that the times of its other answers are still
  // known. If more repeat, or if the pattern stays unclear, a register is assumed. Then an instant is known no better
  // than the two readings around it, which holds in either case.
  static constexpr double kMostRandom = 0.15;
  // Repeats tell nothing if chance explains at most 1 / kFewByChance of them, kTooFewToTell added to their number.
  static constexpr double kFewByChance = 4.0, kTooFewToTell = 16.0;

  std::int64_t pairs_ = 0, same_ = 0;  // pairs of consecutive readings, and those of identical ones
  std::int64_t interrupting_ = 0, interruptions_ = 0;
  double path_ = 0.0;  // sum of all differences
  SmallDifferences differences_;
};

}  // namespace dwell
