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
// Readings once cut off stay so until the restart, though later ones go beyond that end: a larger range makes what was
// read before no better.
//
// An end once found is remembered: readings that pile up there later need no proof against chance. A number far from
// the motion is no clipping: the reading before a clipped one is clipped as well, or near.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class PileUp {
 public:
  // sigma: standard deviation of a reading, rounding included; step: of the rounding, 0: none. The device's numbers.
  struct Noise {
    double sigma, step;
  };
  // The next reading, the one before it, and functions that return the mean difference of consecutive readings and the
  // noise. The latter is called where the reading is beyond all others.
  template <class Difference, class NoiseNow>
  void add(double reading, double before, Difference&& difference, NoiseNow&& noise) noexcept {
    if (reading > top_.numbers[0].value) top_.pass(noise(), stuck_elsewhere(), seen_);
    if (-reading > bottom_.numbers[0].value) bottom_.pass(noise(), stuck_elsewhere(), seen_);
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
  [[nodiscard]] std::int64_t above(const Noise& noise) const noexcept { return top_.cut_off(noise, stuck_elsewhere()); }
  [[nodiscard]] std::int64_t below(const Noise& noise) const noexcept {
    return bottom_.cut_off(noise, stuck_elsewhere());
  }
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  // Loss of the fundamental's amplitude, relative; 0: none. If the part p of all readings is cut off at one end, the
  // fundamental loses (2/3π)(πp)³. What was read before an end was passed has its part in the mean.
  [[nodiscard]] double loss(const Noise& noise) const noexcept {
    if (seen_ == 0) return 0.0;
    const auto all = static_cast<double>(seen_);
    double sum = (top_.lost + bottom_.lost) / all;
    for (const End* end : {&top_, &bottom_}) sum += loss(end->clipped(noise, stuck_elsewhere()), seen_);
    return sum;
  }
  // Where readings are cut off, in the device's numbers; where none is, the largest and the smallest.
  [[nodiscard]] double upper_end() const noexcept { return top_.end(); }
  [[nodiscard]] double lower_end() const noexcept { return -bottom_.end(); }
  // Counts begin anew; ends found so far are remembered.
  void restart(const Noise& noise) noexcept {
    const std::int64_t elsewhere = stuck_elsewhere();
    for (End* end : {&top_, &bottom_}) {
      const double known = end->cut_off(noise, elsewhere) > 0 ? end->end() : end->known;
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
    std::int64_t passed = 0;               // readings cut off at an end that later ones went beyond
    double passed_end = 0.0;               // the newest such end
    double lost = 0.0;                     // of the fundamental until then: relative loss times readings

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

    // A reading goes beyond the largest so far.
    void pass(const Noise& noise, std::int64_t elsewhere, std::int64_t seen) noexcept {
      const std::int64_t here = clipped(noise, elsewhere);
      if (here == 0) return;
      passed += here;
      passed_end = numbers[0].value;
      lost += static_cast<double>(seen) * loss(here, seen);
    }
    [[nodiscard]] std::int64_t cut_off(const Noise& noise, std::int64_t elsewhere) const noexcept {
      return passed + clipped(noise, elsewhere);
    }
    [[nodiscard]] double end() const noexcept { return passed > 0 ? passed_end : numbers[0].value; }

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
  // The same, of one end: `cut_off` of `seen` readings.
  [[nodiscard]] static double loss(std::int64_t cut_off, std::int64_t seen) noexcept {
    return 2 / (3 * std::numbers::pi) *
           std::pow(std::numbers::pi * static_cast<double>(cut_off) / static_cast<double>(seen), 3);
  }
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
