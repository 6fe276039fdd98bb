// The step of a device's rounding as its readings show it: the third smallest difference between two of them, which is
// never below the device's own step, wherever its readings were rounded a second time. And how many differ by one step.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class SmallDifferences {
 public:
  // Two readings one after the other differ by so much, above 0.
  void add(double size) noexcept {
    const double before = step();
    if (size < smallest_[0]) {
      smallest_ = {size, smallest_[0], smallest_[1]};
    } else if (size < smallest_[1]) {
      smallest_ = {smallest_[0], size, smallest_[1]};
    } else if (size < smallest_[2]) {
      smallest_[2] = size;
    }
    if (step() < before / kOneStep) one_step_ = 2;  // the others were larger
    if (size < kOneStep * step()) ++one_step_;
  }
  void restart() noexcept { *this = {}; }

  // The third smallest; INFINITY: not known.
  [[nodiscard]] double step() const noexcept { return smallest_[2]; }
  // The smallest; INFINITY: there is none.
  [[nodiscard]] double least() const noexcept { return smallest_[0]; }
  // How many were one step.
  [[nodiscard]] std::int64_t one_step() const noexcept { return one_step_; }

 private:
  static constexpr double kOneStep = 1.5;  // steps: below, a difference is one
  std::array<double, 3> smallest_{INFINITY, INFINITY, INFINITY};
  std::int64_t one_step_ = 0;
};

}  // namespace dwell
