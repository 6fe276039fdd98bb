// How far readings lie from their prediction: the running median of |e| / a, e the prediction's error and a its gain.
#pragma once

#include <algorithm>

#include "core/intake/median_step.hpp"

namespace dwell {

// Of one channel, in any unit. One thread; real-time safe.
class PredictionErrors {
 public:
  // Whether there were enough errors for a median.
  [[nodiscard]] bool known() const noexcept { return seen_ > kFewest; }
  // An error while the median is not known: of any reading.
  void learn(double error) noexcept {
    ++seen_;
    median_ =
        seen_ <= 8 ? std::max(median_, error) : median_ * (error > median_ ? 1 + 5 * kMedianStep : 1 - 5 * kMedianStep);
  }
  // An error afterwards: of a reading of the motion alone.
  void add(double error) noexcept { median_ *= kTowards[error > median_ ? 1 : 0]; }
  // Another motion has begun, with this error.
  void jump(double error) noexcept { median_ = std::max(median_, error / kJumped); }

  [[nodiscard]] double median() const noexcept { return median_; }
  // Standard deviation of a reading's noise; 0: not known.
  [[nodiscard]] double noise() const noexcept { return known() ? median_ / kMedianOfNormal : 0.0; }

  static constexpr double kMedianOfNormal = 0.6745;  // of |x|, in standard deviations

 private:
  static constexpr int kFewest = 40;  // the median is then known to 20 %
  // A step, by whether the newest is above the median. No branch: noise cannot be guessed.
  static constexpr double kTowards[] = {1 - kMedianStep, 1 + kMedianStep};
  static constexpr double kJumped = 6.0;  // after a jump the median is at least its error over this

  double median_ = 0.0;
  int seen_ = 0;  // until the median is known
};

}  // namespace dwell
