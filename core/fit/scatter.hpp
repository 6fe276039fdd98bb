// Does anything change within a dwell? The phasor of each stretch of it against that of the whole.
//
// Per channel that tells of hum, of repeated readings, of a sensor that has changed. What the coefficients rest on are
// the ratios of the phasors alone: a common factor of all of them, the drive's amplitude that drifts, changes none. So
// the scatter that widens an element is that of its own dynamic stiffness, to first order, stretch by stretch.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <vector>

#include "core/fit/blocks.hpp"
#include "core/fit/harmonic_fit.hpp"

namespace dwell {

// One stretch of one channel.
struct PhasorStretch {
  bool usable = false;       // it has enough samples
  std::complex<double> off;  // its X_1 minus that of the whole, SI of the reading
  double variance = 0.0;     // E|off|² by white residuals
  double chi_squared = 0.0;  // the same as a χ² of two degrees of freedom
};

struct Scatter {
  double ratio = 1.0;  // variance of the stretches over what white residuals explain; 1 on average if they are
  double dof = 0.0;    // degrees of freedom behind it; 0: too little data to say
  // Beyond what chance does: two standard deviations of the ratio.
  [[nodiscard]] bool shows() const noexcept;
  // By what the variance of the mean is to be multiplied. What varies by many times its noise does not do so
  // independently from stretch to stretch: then the spread of the stretches is taken, not that of their mean.
  [[nodiscard]] double widens() const noexcept;
  static constexpr double kUnsteady = 9.0;  // ratio from which that is so, and an operator is told
};

// Blocks [from, to) in about twelve stretches of at least a period, the same for every channel; `fit`: of their sum
// about (omega, t_ref_ns) with `harmonics`. O(blocks · H); allocates; `scratch` is overwritten in this channel.
[[nodiscard]] std::vector<PhasorStretch> phasor_stretches(const Blocks& blocks, int from, int to, int channel,
                                                          int harmonics, const HarmonicFit& fit, double omega,
                                                          std::int64_t t_ref_ns, Totals& scratch);

// Of one channel.
[[nodiscard]] Scatter scatter_of(std::span<const PhasorStretch> stretches) noexcept;

// Of a weighted sum Σ_c w_c X_c over channels, c's stretches at [c]; where a weight is not zero, only stretches in
// which that channel is usable.
[[nodiscard]] Scatter scatter_of_sum(const Eigen::Ref<const Eigen::VectorXcd>& weights,
                                     std::span<const std::vector<PhasorStretch>> channels) noexcept;

}  // namespace dwell
