// Estimates by how much more than its noise the amplitude of an unchanged drive wanders, and how much to tolerate.
//
// The excess is an exponential mean of squared deviation less noise variance. Bound to one thread; real-time safe.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/base/chance.hpp"
#include "core/fit/blocks.hpp"

namespace dwell {

class AmplitudeExcess {
 public:
  void restart() noexcept { *this = {}; }

  // Takes the newest period's amplitude, once a quarter period: its relative deviation from the reference, and the
  // variance of that by noise. tolerance: relative change that makes another drive. u_rounding: relative standard
  // uncertainty by rounding that repeats with the motion.
  void take(double deviation, double variance, double tolerance, double u_rounding) noexcept {
    excess_ += kForget / kQuarters *
               (std::min(deviation * deviation, 9 * variance + tolerance * tolerance) - variance - excess_);
    const double shown = std::clamp(excess_ - kExcess * variance, 0.0, tolerance * tolerance / 2);
    tolerated_ = kBeyond * std::sqrt(shown) + sigmas::kNoise * u_rounding;
  }
  // Relative deviation to tolerate, beside what noise and tolerance allow.
  [[nodiscard]] double tolerated() const noexcept { return tolerated_; }

 private:
  static constexpr double kForget = 1.0 / 64;  // weight of a period in the mean
  static constexpr double kExcess = 0.6;       // part of the noise variance below which no excess shows
  static constexpr double kBeyond = 1.5;       // tolerated multiple of √excess
  double excess_ = 0.0, tolerated_ = 0.0;
};

}  // namespace dwell
