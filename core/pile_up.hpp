// Do the readings pile up at an extreme? A clipped crest is cut off at one number; a crest that is not has, for every
// reading of its topmost number, others of the next one below.
//
// Of a sine sampled at instants of its own the topmost number has at most 1 / (√2 - 1) = 2.4 times the readings of the
// next one (the crest just at the upper end of its rounding step); a crest cut off k steps deep has 2 (k + 1) times as
// many. Sampled at a whole fraction of the period the two counts are whole numbers of readings a period, and up to 4
// times happens: so the topmost may have 5 times as many. Noise of more than a step leaves a tail that thins out: then
// it may have as many, p = 5/6 or 1/2 of the n readings of both. That so many have the topmost number by chance, a part
// x of them, has at most the probability exp(-n [x ln(x/p) + (1-x) ln((1-x)/(1-p))]) (Chernoff, 1952); below 10^-6 it
// is no chance: 26 clipped readings and one beside show above noise, 97 where rounding hides it.
//
// A number that is far from the motion is no clipping: the reading before one that is clipped is clipped as well, or
// near.
#pragma once

#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class PileUp {
 public:
  // The next reading, the one before it, and the mean difference of two readings one after the other.
  void add(double reading, double before, double difference) noexcept {
    ++seen_;
    top_.add(reading, before, difference);
    bottom_.add(-reading, -before, difference);
  }
  // How many of the readings are cut off at either end, of those seen since the restart; 0: none. noisy: the noise of a
  // reading is more than a rounding step.
  [[nodiscard]] std::int64_t above(bool noisy) const noexcept { return top_.clipped(noisy); }
  [[nodiscard]] std::int64_t below(bool noisy) const noexcept { return bottom_.clipped(noisy); }
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  // The largest and the smallest reading seen, in the device's numbers.
  [[nodiscard]] double largest() const noexcept { return top_.value; }
  [[nodiscard]] double smallest() const noexcept { return -bottom_.value; }
  void restart() noexcept {
    top_ = bottom_ = {};
    seen_ = 0;
  }

 private:
  static constexpr double kNoChance = 13.8;  // -ln 10⁻⁶
  static constexpr double kNear = 4.0;       // mean differences: a sine's largest is π/2 of them, with two harmonics 3
  struct End {
    double value = -INFINITY, next = -INFINITY;  // the largest reading, and the next smaller one
    std::int64_t at_value = 0, at_next = 0, from_far = 0;

    void add(double reading, double before, double difference) noexcept {
      if (reading < next) return;
      if (reading > value) {
        next = value;
        at_next = at_value;
        value = reading;
        at_value = 0;
        from_far = 0;
      } else if (reading < value && reading > next) {
        next = reading;
        at_next = 0;
      }
      if (reading == value) {
        ++at_value;
        if (std::abs(reading - before) > kNear * difference) ++from_far;
      } else {
        ++at_next;
      }
    }
    [[nodiscard]] std::int64_t clipped(bool noisy) const noexcept {
      const double top = static_cast<double>(at_value), others = static_cast<double>(at_next), both = top + others;
      const double p = noisy ? 1.0 / 2 : 5.0 / 6;
      // A crest has readings beside it; a channel at rest has none.
      if (at_next == 0 || !(top > p * both) || 8 * from_far >= at_value) return 0;
      const double unlikely = top * std::log(top / (p * both)) + others * std::log(others / ((1 - p) * both));
      return unlikely > kNoChance ? at_value : 0;
    }
  };
  End top_, bottom_;
  std::int64_t seen_ = 0;
};

}  // namespace dwell
