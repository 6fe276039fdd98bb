// Finds the rounding step of readings that were rounded once more and much more finely: printed with six digits, say,
// or held as float32. Their differences are multiples of the step only nearly.
//
// A step s explains kDifferences differences d if most are multiples of it within kOff. The smallest difference is some
// multiple k of it, so k = 1, 2 … kLargestMultiple are tried, and so are those of two larger differences, since a
// glitch may be smaller. The largest step that convinces is it. From small to large differences the step is refined as
// it goes: a difference of m steps gives it m times more accurately, so the next one may have 1/(4 kOff) times as many
// steps and still be a whole number of them beyond doubt. Beyond a wider gap the rest tells nothing.
//
// By chance, numbers on no grid match within ±e with a probability of 2e each. All differences of the same multiple are
// one match, with the largest of their e: a motion that repeats has few different ones. kGlitches of them may be off
// the grid, which multiplies the probability by the ways to choose these. A step convinces at one below kByChance.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace dwell {

// A motion of few steps has few different differences, so beneath four or five digits a step may be missed. Without any
// noise, a motion read thousands of times a period has differences in arithmetic series, which may pass for a step of
// 10⁻⁵ of its amplitude or less: nothing.
//
// Of one channel, in any unit. Bound to one thread; real-time safe. Most calls compare two numbers. A call sorts
// kDifferences numbers, or tries kTries steps with kDifferences divisions each, at most.
class PrintedGrid {
 public:
  // The size of the difference of two consecutive good readings, above 0, finite.
  void add(double size) noexcept {
    if (state_ == State::resting && ++rested_ < rest_) return;
    proceed(size);
  }
  // The step; 0: none found. Its relative error is below kOff over the largest difference in steps.
  [[nodiscard]] double step() const noexcept { return step_; }

 private:
  static constexpr std::size_t kDifferences = 64;
  static constexpr int kTries = 16;
  // A step below 1/512 of a small difference adds next to nothing to the noise.
  static constexpr int kLargestMultiple = 512;
  static constexpr std::size_t kGlitches = kDifferences / 4;
  static constexpr double kOff = 0.1;          // steps: the second rounding's step is a tenth of the first at most
  static constexpr double kSame = 0.01;        // relative: two searches found the same
  static constexpr double kByChance = 1e-12;   // a try; 3e4 tries in the first minute at 1 kHz, 1e6 in each later hour
  static constexpr std::int64_t kRest = 4096;  // differences between two searches, at most; at first kDifferences

  enum class State { collecting, searching, resting };

  void proceed(double size) noexcept;
  void search() noexcept;
  // The step refined from near `step`, or 0 if it does not convince.
  [[nodiscard]] double refined(double step) const noexcept;
  // Ends a search. 0: it found none.
  void take_result(double step) noexcept;

  std::array<double, kDifferences> sizes_{};
  State state_ = State::collecting;
  std::size_t count_ = 0;  // of sizes_
  std::size_t base_ = 0;   // the difference of sizes_ that is taken to be `multiple_` steps
  int multiple_ = 0;
  double largest_ = 0.0;  // step of this search that convinces
  std::int64_t rest_ = kDifferences, rested_ = 0;
  double step_ = 0.0, newest_ = 0.0;  // newest_: what the newest search found
};

}  // namespace dwell
