// Recognizes a held register by runs of identical readings of nearly equal length. A register that is refreshed three,
// four or five times a period shows the same few numbers over and over. Its smallest jump is no rounding step, and no
// run interrupts the motion, so only the runs' lengths tell.
//
// It is held after kEvenRuns runs in a row, of kLeastRun readings or more, whose lengths differ by one at most. Among
// them kReversals jumps must go back by another size than the jump before. A motion as coarse as its rounding steps may
// have even runs as well. But it goes back over the same step, even where a second rounding makes steps unequal. (A run
// of noise is three or more long, and of one of two neighbouring lengths, at most one time in four. Sixteen such runs
// in a row occur once in 10⁵ holds of 10⁴ runs.)
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe.
class EvenRuns {
 public:
  // The next run: so many identical readings between two jumps.
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
  static constexpr double kUnlike = 1.5;     // least ratio of two jumps that differ in size
  std::int64_t shortest_ = 0, longest_ = 0;  // of the latest runs, whose lengths differ by one at most
  int even_ = 0, reversals_ = 0;             // number of these runs; jumps among them that go back by another size
};

}  // namespace dwell
