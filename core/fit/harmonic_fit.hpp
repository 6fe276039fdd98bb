// Fits the harmonics of one channel: from moments to phasors with their covariance.
//
//   s_i = b + Σ_{h=1..H} [ p_h sin(hω(t_i - t_ref)) + q_h cos(hω(t_i - t_ref)) ] + e_i ,     X_h = p_h + j q_h
//
// Ordinary least squares at each sample's own instant (docs/method.md, From samples to moments). With white residuals
// of variance σ², Cov(θ) = σ² R⁻¹, the Cramér-Rao bound for Gaussian noise. R: information matrix of unit variance.
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <complex>

#include "core/base/chance.hpp"
#include "core/fit/totals.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// The fit of one channel's reading; the transducer is not divided out. If not usable, only `samples` is valid.
struct HarmonicFit {
  bool usable = false;  // enough samples, spread well enough, result finite
  double samples = 0.0;
  double mean = kNaN;                                   // b, with the reference added back
  std::array<std::complex<double>, kMaxHarmonics> X{};  // X_1 … X_H at [0] …
  double sigma2 = kNaN;                                 // residual variance, sum of squares over samples - (2H+1)
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Constant(kNaN);  // of (p_1, q_1), white residuals
  // For refining ω: δω = Σ score / Σ information over channels. Each is already divided by this channel's σ².
  double score = 0.0, information = 0.0;  // (rad/s)⁻¹, (rad/s)⁻²
};

// Change of the fundamental within the data: dX_1/dt by least squares on the fit's residuals, in the reading's unit
// per s. A transient, a drive that hunts and a knock all show in it.
struct PhasorSlope {
  std::complex<double> value;
  double variance = 0.0;  // sum over both components, for white residuals; 0: no slope can be told
  [[nodiscard]] bool shows() const noexcept { return variance > 0 && std::norm(value) > nats::kOneIn100 * variance; }
};

// Fits the channels of one set of sums. Channels that share their instants share the factor of R, which is half of the
// work: fit them one after another with the same object. Bound to one thread; real-time safe.
class HarmonicFits {
 public:
  // harmonics <= totals.harmonics(). The totals must outlive this, and not change meanwhile.
  HarmonicFits(const Totals& totals, int harmonics) noexcept;
  // `reference`: the value subtracted from the channel's readings. O(H³); O(H²) with the instants of the call before.
  [[nodiscard]] HarmonicFit fit(int channel, double reference) noexcept;
  // `fit`: of the channel. Only the part of Σu² that does not oscillate is used: below two periods of data the slope is
  // good to a third. O(H³); O(H²) with the instants of the call before.
  [[nodiscard]] PhasorSlope slope(int channel, const HarmonicFit& fit, double reference) noexcept;

 private:
  static constexpr int kMaxParameters = 2 * kMaxHarmonics + 1;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxParameters, 2>;
  // Makes factor_ that of these instants.
  void take(const double* instants) noexcept;

  const Totals& totals_;
  int harmonics_;
  const double* instants_ = nullptr;  // of factor_; null: none yet
  Eigen::LDLT<Matrix, Eigen::Lower> factor_;
  bool solvable_ = false;     // each regressor can be told from the others
  bool has_columns_ = false;  // columns_ is that of these instants
  Columns columns_;           // R⁻¹, those of p_1 and q_1
};

// The fit of a single channel, as HarmonicFits::fit(). Thread-safe.
[[nodiscard]] HarmonicFit fit_harmonics(const Totals& totals, int channel, int harmonics, double reference) noexcept;

}  // namespace dwell
