// Tells by their distances whether repeats come from a register or at random.
//
// If a register is refreshed at a constant rate, it repeats a reading whenever the two rates have slipped by one
// reading. So the distance from one repeat to the next hardly changes. Random repeats have geometrically distributed
// distances. Each distance g (readings) adds the log-likelihood ratio ln(P_A(g) / P_B(g)) to the proof for a register.
// P_A: of a register; P_B: of random repeats.
//
//   P_A = 0.8 / (2 t + 1) for |g - M| ≤ t, t = 1 + 0.12 M,   or 0.1 / (4 t + 1) for |g - 2 M| ≤ 2 t;   + 0.1 P_B
//   P_B = q (1 + q (g - g₀) / n)^-(n + 1),   q = 1 / (M - g₀ + 1)
//
// M: the mean of the n distances before; g₀: the smallest distance that counts. P_B is the geometric distribution whose
// mean is known from n distances. By Wald's inequality random repeats reach a proof of 6.9 with a probability of at
// most 1/1000.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/base/chance.hpp"

namespace dwell {

// Of one channel. Bound to one thread; real-time safe. O(1) per call.
class RepeatDistances {
 public:
  static constexpr double kIrregular = -2.3;  // ln of the part of P_A that is P_B
  static constexpr double kRegular = 0.12;  // relative deviation of a distance; random repeats keep to it once in eight
  static constexpr double kBunch = 0.3;     // part of the mean distance within which repeats are one: instants jitter

  // Counts further readings.
  void pass(std::size_t readings) noexcept {
    if (since_) *since_ += static_cast<double>(readings);
  }
  // Another repeat has ended. too_long: the run is longer than a register's. One so near the one before that jittering
  // instants explain it counts as the same repeat.
  void repeat(bool too_long) noexcept {
    const double least = mean_ >= kBunched ? kBunch * mean_ : 2.0;
    if (known_ > 0 && *since_ < least) return;
    if (too_long) prove(kIrregular);
    if (since_) distance(*since_, least);
    since_ = 0.0;
  }

  // Logarithm of the odds; above 0: a register.
  [[nodiscard]] double proof() const noexcept { return proof_; }
  // The proof has fallen below -ln 1000, and not risen to 0 since.
  [[nodiscard]] bool irregular() const noexcept { return irregular_; }

 private:
  static constexpr double kMost = 16.0;     // bounds the proof: ten repeats show another pattern
  static constexpr double kBunched = 10.0;  // least mean distance for kBunch
  static constexpr int kLearned = 16;       // distances that make up the mean
  // While the mean has fewer than kSettled distances: a distance above kBunchOfFirst means shows that they lie in one
  // bunch.
  static constexpr int kSettled = 3;
  static constexpr double kBunchOfFirst = 3.0;

  void prove(double by) noexcept {
    proof_ = std::clamp(proof_ + by, -kMost, kMost);
    if (proof_ <= -nats::kOneIn1000) irregular_ = true;
    if (proof_ >= 0.0) irregular_ = false;
  }
  void distance(double g, double least) noexcept {
    if (known_ == 0 || (known_ < kSettled && g > kBunchOfFirst * mean_)) {
      mean_ = g;
      known_ = 1;
      return;
    }
    const double n = known_, q = 1 / std::max(1.0, mean_ - least + 1), t = 1 + kRegular * mean_;
    const double random = q * std::pow(1 + q * std::max(0.0, g - least) / n, -(n + 1));
    double regular = 0.1 * random, once = g;
    if (std::abs(g - mean_) <= t) {
      regular += 0.8 / (2 * t + 1);
    } else if (std::abs(g - 2 * mean_) <= 2 * t) {
      regular += 0.1 / (4 * t + 1);  // the repeat between was at a turning point
      once = g / 2;
    } else if (known_ < kSettled) {
      known_ = 0, mean_ = 0.0;  // the distance before may have been that of two beats
    }
    prove(std::log(regular / random));
    known_ = std::min(known_ + 1, kLearned);
    mean_ += (once - mean_) / known_;
  }

  std::optional<double> since_;  // readings since the newest repeat; nothing: there was none
  double mean_ = 0.0;            // of the distances, readings
  int known_ = 0;                // distances in it
  double proof_ = 0.0;
  bool irregular_ = false;
};

}  // namespace dwell
