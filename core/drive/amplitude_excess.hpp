// By how much more than its noise does the amplitude of an unchanged drive wander from period to period? As much is
// tolerated before it is another drive.
//
// Bound to one thread; real-time safe.
#pragma once

#include <algorithm>
#include <cmath>

namespace dwell {

class AmplitudeExcess {
 public:
  void restart() noexcept { *this = {}; }

  // A quarter later, one period's amplitude: relative deviation and its variance by noise. tolerance: relative change
  // that is another drive; u_rounding: relative, by rounding that repeats with the motion.
  void take(double deviation, double variance, double tolerance, double u_rounding) noexcept {
    constexpr int kQuartersAPeriod = 4;
    excess_ += kForget / kQuartersAPeriod *
               (std::min(deviation * deviation, 9 * variance + tolerance * tolerance) - variance - excess_);
    const double shown = std::clamp(excess_ - kExcess * variance, 0.0, tolerance * tolerance / 2);
    tolerated_ = kBeyond * std::sqrt(shown) + kSureOfRounding * u_rounding;
  }
  // What it adds to a deviation that is tolerated, relative.
  [[nodiscard]] double tolerated() const noexcept { return tolerated_; }

 private:
  static constexpr double kForget = 1.0 / 64;     // of the excess, per period
  static constexpr double kExcess = 0.6;          // of the variance by noise, from which an excess shows
  static constexpr double kBeyond = 1.5;          // standard deviations of the excess
  static constexpr double kSureOfRounding = 3.0;  // standard deviations of the mean square that rounding adds
  double excess_ = 0.0, tolerated_ = 0.0;
};

}  // namespace dwell
