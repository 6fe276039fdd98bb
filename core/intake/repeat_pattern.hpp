// Tells a register that is refreshed more slowly than it is read from a gateway that repeats its last answer at random.
// Both show runs of identical readings amid a motion. Two things differ.
//
// The distances. If a register is refreshed at a constant rate, it repeats a reading whenever the two rates have
// slipped by one reading. So the distance from one repeat to the next hardly changes. Random repeats have geometrically
// distributed distances. Each distance g (readings) adds the log-likelihood ratio ln(P_A(g) / P_B(g)) to the proof for
// a register. P_A: of a register; P_B: of random repeats.
//
//   P_A = 0.8 / (2 t + 1) for |g - M| ≤ t, t = 1 + 0.12 M,   or 0.1 / (4 t + 1) for |g - 2 M| ≤ 2 t;   + 0.1 P_B
//   P_B = q (1 + q (g - g₀) / n)^-(n + 1),   q = 1 / (M - g₀ + 1)
//
// M: the mean of the n distances before; g₀: the smallest distance that counts. P_B is the geometric distribution whose
// mean is known from n distances. By Wald's inequality random repeats reach a proof of 7 with a probability of at most
// 1/1000.
//
// The jump after the repeat. The reading after a repeated answer is up to date, so the motion catches up: r identical
// readings are followed by a jump r times as large as those around them. The next value of a register is one refresh
// later, and jumps no farther than any other. Take the jump after the run, per reading of the run, over the mean of the
// jumps around it. This ratio is 1 for repeated answers and 1/2 for a register. (Seen in 50 registers each, refreshed
// every 1.004 … 1.16 readings: at most 0.6 where refreshes jitter by ± 0.3 readings; 0.76 by ± 0.8. In repeated answers
// 0.9 … 1.4, noise up to a quarter of the steepest jump.) With noise as large as the jumps the ratio falls towards 0:
// then a register is assumed.
//
// Repeats are random only if distances and jumps both say so, since jittering instants alone make distances irregular.
// If a register were taken for random repeats, its channel would be late by half a refresh interval, and nothing would
// say so.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Judges the repeats of one channel. Bound to one thread; real-time safe. O(1) per call.
class RepeatPattern {
 public:
  // Counts further readings.
  void pass(std::size_t readings) noexcept { since_ += static_cast<double>(readings); }
  // A run of identical readings has ended. The jumps before and after it are larger than chance. run: its length,
  // readings. few: identical readings are so few that a register would never repeat a reading three times.
  void repeat(std::int64_t run, bool few) noexcept {
    const double least = mean_ >= kBunched ? kBunch * mean_ : 2.0;
    if (distances_ > 0 && since_ < least) return;  // instants jitter: repeats that near are one
    if (few && run > kLongest) prove(kIrregular);
    if (distances_ >= 0) distance(since_, least);
    if (distances_ < 0) distances_ = 0;
    since_ = 0.0;
  }
  // How the motion went on. run: length of the run, readings. before, after, next: the jump before the run, the one
  // after it, and the one after that. mean: mean size of all jumps. All jumps are in units of the device. Only a steep
  // motion counts: elsewhere the sign of noise would pass for a direction.
  void caught(std::int64_t run, double before, double after, double next, double mean) noexcept {
    const double moved = before + after + next;
    if (!(std::abs(moved) > kSteep * mean)) return;
    if (++jumps_ > kRemembered) jumps_ /= 2, caught_ /= 2, around_ /= 2;
    caught_ += std::copysign(1.0, moved) * after / static_cast<double>(run);
    around_ += std::copysign(0.5, moved) * (before + next);
  }

  // Whether the repeats come at a constant rate of refresh.
  [[nodiscard]] bool regular() const noexcept { return proof_ >= (catches_up() ? kSurely : kSure); }
  // Whether they come at random.
  [[nodiscard]] bool random() const noexcept { return irregular_ && catches_up(); }
  // Whether they may turn out to be random once more jumps are known.
  [[nodiscard]] bool may_be_random() const noexcept {
    return proof_ < 0.0 && (jumps_ < kFewest || caught_ >= kUnclear * around_);
  }
  // Whether at most one distance speaks against a register, and the jumps do not.
  [[nodiscard]] bool may_be_regular() const noexcept { return proof_ >= kIrregular - 0.2 && !catches_up(); }

 private:
  // kSure: -ln of 1/1000. kSurely: of 6e-6, where the jumps speak against it. kMost bounds the proof, so that another
  // pattern shows after some ten repeats.
  static constexpr double kSure = 7.0, kSurely = 12.0, kMost = 16.0;
  static constexpr double kIrregular = -2.3;                 // ln of the part of P_A that is P_B
  static constexpr double kBunch = 0.3, kBunched = 10.0;     // of the mean distance; least mean distance for that
  static constexpr double kRegular = 0.12;                   // relative deviation of a distance, as RepeatBeat's
  static constexpr double kSteep = 3.0;                      // mean jumps, by which three jumps move
  static constexpr double kCaughtUp = 0.75, kUnclear = 0.6;  // 1: repeated answers; 1/2: a register
  static constexpr std::int64_t kLongest = 3;                // run of a register that seldom repeats one
  static constexpr int kFewest = 4, kRemembered = 256;       // jumps
  static constexpr int kLearned = 16;                        // distances that make up the mean
  // While the mean has fewer than kSettled distances: a distance above kBunchOfFirst means shows that they lie in one
  // bunch.
  static constexpr int kSettled = 3;
  static constexpr double kBunchOfFirst = 3.0;

  [[nodiscard]] bool catches_up() const noexcept { return jumps_ >= kFewest && caught_ >= kCaughtUp * around_; }
  void prove(double by) noexcept {
    proof_ = std::clamp(proof_ + by, -kMost, kMost);
    if (proof_ <= -kSure) irregular_ = true;
    if (proof_ >= 0.0) irregular_ = false;
  }
  void distance(double g, double least) noexcept {
    if (distances_ == 0 || (distances_ < kSettled && g > kBunchOfFirst * mean_)) {
      mean_ = g;
      distances_ = 1;
      return;
    }
    const double n = distances_, q = 1 / std::max(1.0, mean_ - least + 1), t = 1 + kRegular * mean_;
    const double random = q * std::pow(1 + q * std::max(0.0, g - least) / n, -(n + 1));
    double regular = 0.1 * random, once = g;
    if (std::abs(g - mean_) <= t) {
      regular += 0.8 / (2 * t + 1);
    } else if (std::abs(g - 2 * mean_) <= 2 * t) {
      regular += 0.1 / (4 * t + 1);  // the repeat between was at a turning point
      once = g / 2;
    } else if (distances_ < kSettled) {
      distances_ = 0, mean_ = 0.0;  // the distance before may have been that of two beats
    }
    prove(std::log(regular / random));
    distances_ = std::min(distances_ + 1, kLearned);
    mean_ += (once - mean_) / distances_;
  }

  double since_ = 0.0, mean_ = 0.0, proof_ = 0.0;  // readings; readings; above 0: a register
  int distances_ = -1;                             // known; below 0: no repeat has come yet
  bool irregular_ = false;                         // the proof has fallen below -kSure, and not risen to 0 since
  int jumps_ = 0;
  double caught_ = 0.0, around_ = 0.0;  // sums over these: the jump after a run, per reading of it; the jumps around
};

}  // namespace dwell
