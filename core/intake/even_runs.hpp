// Runs of identical readings that are all about as long: a register that is refreshed three, four or five times a
// period shows the same few numbers over and over. Its smallest jump is no rounding step, and none interrupts the
// motion; there the runs themselves tell.
//
// kEvenRuns in a row of kLeastRun readings or more that differ by one at most, and kReversals jumps among them that go
// back by another size than the jump before. Of a motion as coarse as its rounding steps runs may be as even, but it
// goes back over the same step, however unequal a second rounding has made the steps. (Noise makes a run of three or
// more one of two lengths at most one time in four: so many in a row once in 10⁵ holds of 10⁴ runs.)
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe.
class EvenRuns {
 public:
  // A run of so many identical readings lies between two jumps.
  void add(std::int64_t run, double jump_before, double jump_after) noexcept {
    if (run < kLeastRun || run > shortest_ + 1 || run < longest_ - 1) {
      even_ = reversals_ = 0;
      shortest_ = longest_ = run;
    }
    if (run < kLeastRun) return;
    shortest_ = std::min(shortest_, run);
    longest_ = std::max(longest_, run);
    even_ = std::min(even_ + 1, kEvenRuns);
    const double a = std::abs(jump_before), b = std::abs(jump_after);
    if (jump_before * jump_after < 0 && std::max(a, b) > kUnlike * std::min(a, b))
      reversals_ = std::min(reversals_ + 1, kReversals);
  }
  [[nodiscard]] bool found() const noexcept { return even_ == kEvenRuns && reversals_ == kReversals; }
  void restart() noexcept { even_ = reversals_ = 0; }

 private:
  static constexpr int kEvenRuns = 16, kReversals = 3;
  static constexpr std::int64_t kLeastRun = 3;
  static constexpr double kUnlike = 1.5;     // ratio of two jumps of another size
  std::int64_t shortest_ = 0, longest_ = 0;  // of the latest runs whose lengths differ by one at most
  int even_ = 0, reversals_ = 0;             // how many these are, and jumps among them that go back by another size
};

}  // namespace dwell
