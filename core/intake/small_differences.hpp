// Finds the rounding step that readings show: the third smallest difference of two of them. A second rounding never
// makes it smaller than the device's own. Also counts the differences of one step.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class SmallDifferences {
 public:
  // The absolute difference of two consecutive readings, above 0.
  void add(double size) noexcept {
    if (size < smallest_[2]) add_small(size);
    if (size < kOneStep * step()) ++one_step_;
  }
  void restart() noexcept { *this = {}; }

  // The third smallest difference; INFINITY: not known.
  [[nodiscard]] double step() const noexcept { return smallest_[2]; }
  // The smallest difference; INFINITY: there is none.
  [[nodiscard]] double least() const noexcept { return smallest_[0]; }
  // Number of differences of one step.
  [[nodiscard]] std::int64_t one_step() const noexcept { return one_step_; }

 private:
  // Rare after the first readings: below the third smallest.
  void add_small(double size) noexcept {
    const double before = step();
    if (size < smallest_[0]) {
      smallest_ = {size, smallest_[0], smallest_[1]};
    } else if (size < smallest_[1]) {
      smallest_ = {smallest_[0], size, smallest_[1]};
    } else {
      smallest_[2] = size;
    }
    if (step() < before / kOneStep) one_step_ = 2;  // the other two differences were larger
  }

  static constexpr double kOneStep = 1.5;  // steps: a smaller difference is one step
  std::array<double, 3> smallest_{INFINITY, INFINITY, INFINITY};
  std::int64_t one_step_ = 0;
};

}  // namespace dwell
