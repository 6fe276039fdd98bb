// Do the readings pile up at an extreme? A clipped crest is cut off at one number; a crest that is not has, for every
// reading of its topmost number, others of the numbers below.
//
// The topmost numbers that occur lie within d + 1 rounding steps. Of a sine sampled at instants of its own at most the
// part 1/√(d + 1) of the readings of these steps is in the topmost one (its crest just at the upper end of that step);
// noise leaves a tail that thins out, at most half of the readings of two steps in the upper one. The noise must
// be at least 3/4 of a step: with less, more than half of the readings of one and the same instant of the motion can be
// one number. A crest cut off has more. That noise puts so many into the topmost step by chance, a part x of n where
// the part p is possible, has at most the probability exp(-n [x ln(x/p) + (1-x) ln((1-x)/(1-p))]) (Chernoff, 1952);
// below 10^-6 it is no chance: once for the next number, once for all others. 26 clipped readings and one in the next
// step show; beside one that is a thousand steps away, as noise of many steps has it, six do. There a reading that is
// repeated at once counts once, since a register may be held; fewer than four may be repeats of one reading.
//
// Where rounding hides the noise, single numbers are compared. Sampled at a whole fraction of the period their counts
// are whole numbers of readings a period, and up to 4 times happens: so the topmost may have 5 times as many as the
// commonest of the others, p = 5/6; 97 clipped readings and one beside show. It is the commonest that counts: the
// number next to a crest may have only what little noise there is.
//
// An end once found stays where it is: later on readings that pile up there need not prove that it is no chance.
//
// A number that is far from the motion is no clipping: the reading before one that is clipped is clipped as well, or
// near.
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
  // Standard deviation of a reading, that of rounding included, and the rounding step, in the device's numbers; 0:
  // none.
  struct Noise {
    double sigma, step;
  };
  // The next reading, the one before it, and the mean difference of two readings one after the other.
  void add(double reading, double before, double difference) noexcept {
    ++seen_;
    top_.add(reading, before, difference);
    bottom_.add(-reading, -before, difference);
  }
  // How many of the readings are cut off at either end, of those seen since the restart; 0: none.
  [[nodiscard]] std::int64_t above(const Noise& noise) const noexcept { return top_.clipped(noise); }
  [[nodiscard]] std::int64_t below(const Noise& noise) const noexcept { return bottom_.clipped(noise); }
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  // The largest and the smallest reading seen, in the device's numbers.
  [[nodiscard]] double largest() const noexcept { return top_.numbers[0].value; }
  [[nodiscard]] double smallest() const noexcept { return -bottom_.numbers[0].value; }
  // Ends found so far are kept.
  void restart(const Noise& noise) noexcept {
    for (End* end : {&top_, &bottom_}) {
      const double known = end->clipped(noise) > 0 ? end->numbers[0].value : end->known;
      *end = {};
      end->known = known;
    }
    seen_ = 0;
  }

 private:
  static constexpr std::size_t kDepth = 12;  // topmost numbers that are counted
  static constexpr double kNoChance = 13.8;  // -ln 10⁻⁶
  static constexpr std::int64_t kFewest = 4;
  static constexpr double kUnrounded = 1e6;  // steps: more tell no more
  static constexpr double kNoisy = 0.8;      // steps: 3/4 of noise, and the 1/√12 of rounding
  static constexpr double kNear = 4.0;       // mean differences: a sine's largest is π/2 of them, with two harmonics 3
  struct Number {
    double value = -INFINITY;
    std::int64_t readings = 0, runs = 0;  // of equal readings
  };
  struct End {
    std::array<Number, kDepth> numbers;  // the largest first
    std::int64_t from_far = 0;           // of the readings of the largest
    double known = INFINITY;             // where the transducer was found to end

    void add(double reading, double before, double difference) noexcept {
      if (reading < numbers.back().value) return;
      const auto at = std::find_if(numbers.begin(), numbers.end(), [&](const Number& n) { return reading >= n.value; });
      if (reading > at->value) {
        std::move_backward(at, numbers.end() - 1, numbers.end());
        *at = {reading};
        if (at == numbers.begin()) from_far = 0;
      }
      ++at->readings;
      if (reading != before) ++at->runs;
      if (at == numbers.begin() && std::abs(reading - before) > kNear * difference) ++from_far;
    }

    [[nodiscard]] std::int64_t clipped(const Noise& noise) const noexcept {
      const Number &topmost = numbers[0], &next = numbers[1];
      // A crest has readings beside it; a channel at rest has none.
      if (next.readings == 0 || 8 * from_far >= topmost.readings) return 0;
      const bool again = topmost.value == known;
      const double unlikely = again ? 0.0 : kNoChance;
      if (!(noise.sigma > kNoisy * noise.step)) {
        std::int64_t others = 0;
        for (std::size_t i = 1; i < kDepth; ++i) others = std::max(others, numbers[i].readings);
        return exceeds(topmost.readings, others, 5.0 / 6, unlikely) ? topmost.readings : 0;
      }
      if (exceeds(topmost.readings, next.readings, 1.0 / 2, unlikely)) return topmost.readings;
      if (topmost.runs < kFewest) return 0;
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
  // Whether `top` of `top + others` is less probable than exp(-unlikely) where each is at the top with probability p.
  [[nodiscard]] static bool exceeds(std::int64_t top, std::int64_t others, double p, double unlikely) noexcept {
    const auto a = static_cast<double>(top), b = static_cast<double>(others), all = a + b;
    return a > p * all && a * std::log(a / (p * all)) + b * std::log(b / ((1 - p) * all)) > unlikely;
  }
  End top_, bottom_;
  std::int64_t seen_ = 0;
};

}  // namespace dwell
