// Tells at which frequency mains hum, or another line, appears in a channel's readings.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/angle.hpp"

namespace dwell {

inline constexpr double kMainsFundamentals_hz[] = {50.0, 60.0};
inline constexpr double kMainsWander_hz = 0.1;  // by a grid in normal operation, and as much again by a sampling clock

// Measures how regularly a channel is sampled: mean and variance of the steps between readings. Steps over lost
// readings are left out. Bound to one thread; a few operations per step.
class SamplingRegularity {
 public:
  void add(double step_s) noexcept {
    if (!(step_s > 0)) return;
    if (n_ >= kMost && step_s <= kLong * mean_s_) {  // the usual case: nothing is lost, and the weight stays
      lost_ = 0;
      return learn(step_s);
    }
    // Among the first few steps the shortest is the rule: one gap would bias their mean for long.
    if (n_ <= kFew && kLong * step_s < mean_s_) n_ = 0;
    if (n_ > 0 && step_s > kLong * mean_s_ && ++lost_ < kNotLost) return;
    if (lost_ == kNotLost) n_ = 0;  // so many long steps in a row are the rule; those before were a burst
    lost_ = 0;
    if (n_ < kMost) weight_ = 1 / ++n_;
    learn(step_s);
  }
  // So many steps of the same length.
  void add_evenly(double step_s, std::size_t steps) noexcept {
    // A mean of nothing but such steps stays as it is.
    if (n_ >= kMost && step_s == mean_s_ && variance_ == 0) {
      lost_ = 0;
      return;
    }
    for (std::size_t i = 0; i < steps; ++i) add(step_s);
  }
  // Mean interval between two readings, s; 0: none is known.
  [[nodiscard]] double interval_s() const noexcept { return mean_s_; }
  // Distance of f_hz from the line or its nearest alias, Hz. An alias that jitter spreads by 3 rad is left out.
  [[nodiscard]] double distance_hz(double line_hz, double f_hz) const noexcept {
    double least = std::abs(line_hz - f_hz);
    if (!(mean_s_ > 0)) return least;
    const double rate_hz = 1 / mean_s_, jitter_s = std::sqrt(variance_);
    for (int sign = -1; sign <= 1; sign += 2) {
      const double off = line_hz + sign * f_hz, folds = std::round(off / rate_hz);
      if (kTwoPi * std::abs(folds) * rate_hz * jitter_s < 3) least = std::min(least, std::abs(off - folds * rate_hz));
    }
    return least;
  }
  // The alias of a line nearest to f_hz: its distance, Hz (infinity: none folds there), and the part of the line's
  // amplitude that irregular instants leave, exp(-φ²/2), with φ the rms phase by which they shift it.
  struct Alias {
    double apart_hz = std::numeric_limits<double>::infinity(), kept = 0.0;
  };
  [[nodiscard]] Alias alias(double line_hz, double f_hz) const noexcept {
    Alias nearest;
    if (!(mean_s_ > 0)) return nearest;
    for (int sign = -1; sign <= 1; sign += 2) {
      const double off = line_hz + sign * f_hz, folds = std::round(off * mean_s_);
      const double apart_hz = std::abs(off - folds / mean_s_);
      if (folds < 1 || apart_hz >= nearest.apart_hz) continue;
      // A step lies between two instants, each with half of the step's variance.
      const double phase = kTwoPi * folds / mean_s_;
      nearest = {apart_hz, std::exp(-0.25 * phase * phase * variance_)};
    }
    return nearest;
  }

 private:
  void learn(double step_s) noexcept {
    const double off = step_s - mean_s_;
    mean_s_ += off * weight_;
    variance_ += (off * off * (1 - weight_) - variance_) * weight_;
  }

  static constexpr double kMost = 4096;  // steps that the mean remembers
  static constexpr int kNotLost = 16;
  static constexpr double kFew = 8, kLong = 1.6;  // steps; multiple of the mean that shows a lost reading
  int lost_ = 0;                                  // long steps in a row
  double n_ = 0, weight_ = 1, mean_s_ = 0, variance_ = 0;
};

}  // namespace dwell
