// The harmonic fit: from moments to phasors, with their covariance.
//
//   s_i = b + Σ_{h=1..H} [ p_h sin(hω(t_i - t_ref)) + q_h cos(hω(t_i - t_ref)) ] + e_i ,     X_h = p_h + j q_h
//
// Ordinary least squares on each sample's own instant (docs/method.md, From samples to moments). White residuals of
// variance σ² give Cov(θ) = σ² R⁻¹, the Cramér-Rao bound for Gaussian noise.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>

#include "core/fit/totals.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// The fit of one channel, of the reading as it is (transducer not divided out). Not usable: all NaN.
struct HarmonicFit {
  bool usable = false;  // enough samples, spread enough, result finite
  double samples = 0.0;
  double mean = kNaN;                                   // b, the reference added back
  std::array<std::complex<double>, kMaxHarmonics> X{};  // X_1 … X_H at [0] …
  double sigma2 = kNaN;                                 // residual variance, sum of squares over samples - (2H+1)
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Constant(kNaN);  // of (p_1, q_1), white residuals
  // For refining ω: the residuals' slope and curvature by ω in this channel, each already divided by σ².
  double score = 0.0, information = 0.0;  // s (rad/s)⁻¹ … : δω = Σ score / Σ information
};

// Fits one channel over the totals with `harmonics` <= totals.harmonics(). `reference` is what the readings were taken
// relative to. O(H³). Real-time safe, thread-safe.
[[nodiscard]] HarmonicFit fit_harmonics(const Totals& totals, int channel, int harmonics, double reference) noexcept;

// How the fundamental changes within the data: dX_1/dt by least squares on the fit's residuals, s⁻¹ of the reading's
// unit. A transient, a drive that hunts and a knock all show in it.
struct PhasorSlope {
  std::complex<double> value;
  double variance = 0.0;  // of both components together, white residuals; 0: there is no slope to tell
  // Of |value|² over its variance: passed by chance once in a hundred channels (χ² of two degrees of freedom
  // above 9.2). Twice that would leave changes of three standard deviations of a phasor unsaid, half of it speak in
  // each tenth.
  static constexpr double kShows = 4.6;
  [[nodiscard]] bool shows() const noexcept { return variance > 0 && std::norm(value) > kShows * variance; }
};
// `fit`: of these totals with `harmonics`. Of Σu² the part that does not oscillate: at less than two periods the slope
// is good to a third. O(H³). Real-time safe, thread-safe.
[[nodiscard]] PhasorSlope fit_slope(const Totals& totals, int channel, int harmonics, const HarmonicFit& fit,
                                    double reference) noexcept;

}  // namespace dwell
