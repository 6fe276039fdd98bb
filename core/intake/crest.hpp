// The topmost numbers that a channel has read, and whether its crest is cut off there. A clipped crest is cut off at
// one number. An unclipped one has readings of the numbers below its topmost number as well.
//
// The test: of n readings the part x is at the top, where at most the part p is possible. By chance that has at most
// the probability exp(-n [x ln(x/p) + (1-x) ln((1-x)/(1-p))]) (Chernoff, 1952). Below 10^-6 the channel is clipped.
//
// Noise of at least 3/4 of a rounding step: numbers thin out towards the top. The topmost has at most as many readings
// as the commonest of the others, p = 1/2. 26 clipped readings and one beside show. (With less noise more than half of
// the readings at one instant of the motion can be one number.)
//
// Much noise: there are many numbers with few readings each. Then the topmost d + 1 steps count. Of a sine at most the
// part 1/√(d + 1) of them is in the topmost step; the worst crest lies just at its upper end. Beside one reading a
// thousand steps away six show. Identical readings in a row count once, since a register may be held. Fewer than four
// may be repeats of one reading.
//
// Less noise: the crest decides. The topmost number of a sine has at most 1/(√2 - 1) = 2.4 times the readings of the
// next one. With a crest flattened by harmonics it has 1/(2^¼ - 1) = 5.3 times. Sampled at a whole fraction of the
// period, where counts are whole numbers of readings a period, it has about twice that: p = 10/11. A crest cut off by
// less than five steps is not found.
//
// Few readings a period at a whole rate: runs decide. A run of identical readings longer than any crest explains is a
// repeated answer or a crest cut off. Repeats come at any instant of the motion, so at most one time in five at the
// extreme. Five or more runs there, and hardly any elsewhere, are no repeats (passed by chance less than once in 1000,
// where there are such runs at all).
//
// A number far from the motion is no clipping: the reading before a clipped one is clipped as well, or near.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Of one end of one channel, in the device's own numbers; for the lower end, of their negatives. Bound to one thread;
// real-time safe.
class Crest {
 public:
  // sigma: standard deviation of a reading, rounding included; step: of the rounding, 0: none. The device's numbers.
  struct Noise {
    double sigma, step;
  };
  // Proof asked for, -ln of the probability that chance brings as much.
  struct Proof {
    double unlikely;       // of a topmost number with many readings
    double unlikely_runs;  // of long runs at the topmost number
  };
  static constexpr Proof kProof{13.8, 6.9};  // 10⁻⁶, 10⁻³
  // Steps of rounding. A crest cut off by fewer is not found, where noise does not smooth the steps.
  static constexpr double kUnseenSteps = 5.0;
  // For an end that is known already: one reading more than an uncut crest can have suffices.
  static constexpr Proof kNone{0.0, 0.0};

  // The next reading, the one before it, and a function that returns the mean difference of consecutive readings.
  template <class Difference>
  void add(double reading, double before, Difference&& difference) noexcept {
    at_top_ = reading >= top();
    if (reading < least()) return;
    const auto at = std::find_if(numbers_.begin(), numbers_.end(), [&](const Number& n) { return reading >= n.value; });
    if (reading > at->value) {
      std::move_backward(at, numbers_.end() - 1, numbers_.end());
      *at = {reading};
      if (at == numbers_.begin()) from_far_ = stuck_ = 0;
    }
    ++at->readings;
    if (reading != before) ++at->runs;
    if (at == numbers_.begin() && std::abs(reading - before) > kNear * difference()) ++from_far_;
  }
  // The newest reading makes a run of identical ones longer than a crest explains. Called once per run.
  void stuck() noexcept {
    if (at_top_) ++stuck_;
  }

  // The largest reading; -infinity: there is none.
  [[nodiscard]] double top() const noexcept { return numbers_[0].value; }
  // Smaller readings change nothing; -infinity: any reading may.
  [[nodiscard]] double least() const noexcept { return numbers_.back().value; }
  [[nodiscard]] std::int64_t runs_at_top() const noexcept { return stuck_; }  // long ones
  // How many readings are cut off, all of them at top(); 0: none. elsewhere: long runs at neither end.
  [[nodiscard]] std::int64_t cut_off(const Noise& noise, std::int64_t elsewhere, const Proof& proof) const noexcept {
    const Number &topmost = numbers_[0], &next = numbers_[1];
    // A crest has readings beside it; a channel at rest has none.
    if (next.readings == 0 || 8 * from_far_ >= topmost.readings) return 0;
    const bool noisy = noise.sigma > kNoisy * noise.step;
    std::int64_t commonest = 0;
    for (std::size_t i = 1; i < kDepth; ++i) commonest = std::max(commonest, numbers_[i].readings);
    if (exceeds(topmost.readings, commonest, noisy ? 1.0 / 2 : 10.0 / 11, proof.unlikely)) return topmost.readings;
    if (exceeds(stuck_, elsewhere, kStuckAtExtreme, proof.unlikely_runs)) return topmost.readings;
    if (!noisy || topmost.runs < kFewest) return 0;
    std::int64_t others = 0;
    for (std::size_t i = 1; i < kDepth && numbers_[i].runs > 0; ++i) {
      others += numbers_[i].runs;
      const double steps = noise.step > 0 ? (topmost.value - numbers_[i].value) / noise.step : kUnrounded;
      const double p = 1 / std::sqrt(1 + std::clamp(steps, 1.0, kUnrounded));
      const double unlikely = proof.unlikely > 0 ? proof.unlikely + std::log(kDepth) : 0.0;  // so many are tried
      if (exceeds(topmost.runs, others, p, unlikely)) return topmost.readings;
    }
    return 0;
  }

 private:
  static constexpr std::size_t kDepth = 12;  // topmost numbers that are counted
  static constexpr std::int64_t kFewest = 4;
  static constexpr double kUnrounded = 1e6;  // steps: beyond, p no longer matters
  static constexpr double kNoisy = 0.8;      // steps: 3/4 of noise, with the 1/√12 of rounding
  static constexpr double kStuckAtExtreme = 1.0 / 5;
  static constexpr double kNear = 4.0;  // mean differences: the largest of a sine is π/2 of them, with two harmonics 3
  struct Number {
    double value = -INFINITY;
    std::int64_t readings = 0, runs = 0;  // runs of equal ones
  };
  // Whether `top` of `top + others` has a probability below exp(-unlikely), if each is at the top with probability p.
  [[nodiscard]] static bool exceeds(std::int64_t top, std::int64_t others, double p, double unlikely) noexcept {
    const auto a = static_cast<double>(top), b = static_cast<double>(others), all = a + b;
    if (!(a > p * all)) return false;
    return a * std::log(a / (p * all)) + (b > 0 ? b * std::log(b / ((1 - p) * all)) : 0.0) > unlikely;
  }

  std::array<Number, kDepth> numbers_;     // the largest first
  std::int64_t from_far_ = 0, stuck_ = 0;  // of the largest number: readings from far away; long runs
  bool at_top_ = false;                    // the newest reading is the largest
};

}  // namespace dwell
