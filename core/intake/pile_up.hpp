// Finds out whether a channel is clipped: then its readings pile up at an extreme. A clipped crest is cut off at one
// number. An unclipped one has readings of the numbers below its topmost number as well.
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
// less than five steps is not found. Its error is smaller than that of rounding.
//
// Few readings a period at a whole rate: runs decide. A run of identical readings longer than any crest explains is a
// repeated answer or a crest cut off. Repeats come at any instant of the motion, so at most one time in five at the
// extreme. Five or more runs there, and hardly any elsewhere, are no repeats (passed by chance less than once in 1000,
// where there are such runs at all).
//
// An end once found is remembered: readings that pile up there later need no proof against chance. A number far from
// the motion is no clipping: the reading before a clipped one is clipped as well, or near.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class PileUp {
 public:
  // sigma: standard deviation of a reading, rounding included; step: of the rounding, 0: none. The device's numbers.
  struct Noise {
    double sigma, step;
  };
  // The next reading, the one before it, and a function that returns the mean difference of consecutive readings.
  template <class Difference>
  void add(double reading, double before, Difference&& difference) noexcept {
    ++seen_;
    top_.add(reading, before, difference);
    bottom_.add(-reading, -before, difference);
  }
  // The newest reading makes a run of identical ones longer than a crest explains. Called once per run.
  void stuck() noexcept {
    ++stuck_;
    top_.see_stuck();
    bottom_.see_stuck();
  }
  // How many readings since the restart are cut off at the upper and at the lower end; 0: none.
  [[nodiscard]] std::int64_t above(const Noise& noise) const noexcept { return top_.clipped(noise, stuck_elsewhere()); }
  [[nodiscard]] std::int64_t below(const Noise& noise) const noexcept {
    return bottom_.clipped(noise, stuck_elsewhere());
  }
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  // The largest and the smallest reading since the restart, in the device's numbers.
  [[nodiscard]] double largest() const noexcept { return top_.numbers[0].value; }
  [[nodiscard]] double smallest() const noexcept { return -bottom_.numbers[0].value; }
  // Counts begin anew; ends found so far are remembered.
  void restart(const Noise& noise) noexcept {
    const std::int64_t elsewhere = stuck_elsewhere();
    for (End* end : {&top_, &bottom_}) {
      const double known = end->clipped(noise, elsewhere) > 0 ? end->numbers[0].value : end->known;
      *end = {};
      end->known = known;
    }
    seen_ = stuck_ = 0;
  }

 private:
  static constexpr std::size_t kDepth = 12;  // topmost numbers that are counted
  static constexpr double kNoChance = 13.8;  // -ln 10⁻⁶
  static constexpr std::int64_t kFewest = 4;
  static constexpr double kUnrounded = 1e6;  // steps: beyond, p no longer matters
  static constexpr double kNoisy = 0.8;      // steps: 3/4 of noise, with the 1/√12 of rounding
  static constexpr double kStuckAtExtreme = 1.0 / 5, kHardlyChance = 6.9;  // -ln 10⁻³
  static constexpr double kNear = 4.0;  // mean differences: the largest of a sine is π/2 of them, with two harmonics 3
  struct Number {
    double value = -INFINITY;
    std::int64_t readings = 0, runs = 0;  // runs of equal ones
  };
  struct End {
    std::array<Number, kDepth> numbers;    // the largest first
    std::int64_t from_far = 0, stuck = 0;  // of the largest number: readings from far away; long runs
    bool at_top = false;                   // the newest reading is the largest
    double known = INFINITY;               // the end of the transducer's range, found before

    template <class Difference>
    void add(double reading, double before, Difference&& difference) noexcept {
      at_top = reading >= numbers[0].value;
      if (reading < numbers.back().value) return;
      const auto at = std::find_if(numbers.begin(), numbers.end(), [&](const Number& n) { return reading >= n.value; });
      if (reading > at->value) {
        std::move_backward(at, numbers.end() - 1, numbers.end());
        *at = {reading};
        if (at == numbers.begin()) from_far = stuck = 0;
      }
      ++at->readings;
      if (reading != before) ++at->runs;
      if (at == numbers.begin() && std::abs(reading - before) > kNear * difference()) ++from_far;
    }

    void see_stuck() noexcept {
      if (at_top) ++stuck;
    }

    // elsewhere: number of long runs at neither end.
    [[nodiscard]] std::int64_t clipped(const Noise& noise, std::int64_t elsewhere) const noexcept {
      const Number &topmost = numbers[0], &next = numbers[1];
      // A crest has readings beside it; a channel at rest has none.
      if (next.readings == 0 || 8 * from_far >= topmost.readings) return 0;
      const bool again = topmost.value == known, noisy = noise.sigma > kNoisy * noise.step;
      const double unlikely = again ? 0.0 : kNoChance;
      std::int64_t commonest = 0;
      for (std::size_t i = 1; i < kDepth; ++i) commonest = std::max(commonest, numbers[i].readings);
      if (exceeds(topmost.readings, commonest, noisy ? 1.0 / 2 : 10.0 / 11, unlikely)) return topmost.readings;
      if (exceeds(stuck, elsewhere, kStuckAtExtreme, again ? 0.0 : kHardlyChance)) return topmost.readings;
      if (!noisy || topmost.runs < kFewest) return 0;
      std::int64_t others = 0;
      for (std::size_t i = 1; i < kDepth && numbers[i].runs > 0; ++i) {
        others += numbers[i].runs;
        const double steps = noise.step > 0 ? (topmost.value - numbers[i].value) / noise.step : kUnrounded;
        const double p = 1 / std::sqrt(1 + std::clamp(steps, 1.0, kUnrounded));
        if (exceeds(topmost.runs, others, p, again ? 0.0 : kNoChance + std::log(kDepth))) return topmost.readings;
      }
      return 0;
    }
  };
  // Whether `top` of `top + others` has a probability below exp(-unlikely), if each is at the top with probability p.
  [[nodiscard]] static bool exceeds(std::int64_t top, std::int64_t others, double p, double unlikely) noexcept {
    const auto a = static_cast<double>(top), b = static_cast<double>(others), all = a + b;
    if (!(a > p * all)) return false;
    return a * std::log(a / (p * all)) + (b > 0 ? b * std::log(b / ((1 - p) * all)) : 0.0) > unlikely;
  }
  [[nodiscard]] std::int64_t stuck_elsewhere() const noexcept { return stuck_ - top_.stuck - bottom_.stuck; }

  End top_, bottom_;
  std::int64_t seen_ = 0, stuck_ = 0;
};

}  // namespace dwell
