// The scatter of a dwell's phasors. The dwell is cut into stretches, and each stretch's phasor is compared with that of
// the whole dwell. If they differ by more than noise explains, something changed within the dwell.
//
// The scatter of one channel shows hum, repeated readings, or a sensor that has changed. Coefficients depend on ratios
// of phasors only: a factor common to all channels, such as a drifting drive amplitude, changes none. So an element's
// uncertainty is widened by the scatter of its own dynamic stiffness, to first order.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <vector>

#include "core/fit/blocks.hpp"
#include "core/fit/harmonic_fit.hpp"

namespace dwell {

// Parts into which the data of a dwell are cut, so that changes within it show. Twelve give their spread to 20 %.
inline constexpr int kStretches = 12;

// One stretch of one channel.
struct PhasorStretch {
  bool usable = false;       // it has enough samples
  std::complex<double> off;  // its X_1 minus that of the whole, SI of the reading
  double variance = 0.0;     // E|off|² for white residuals
  double chi_squared = 0.0;  // off as χ² of two degrees of freedom

  // more: E|error|² of another error of this stretch, SI of the reading squared, equal in both components.
  void add_variance(double more) noexcept {
    if (variance > 0) chi_squared *= variance / (variance + more);
    variance += more;
  }
};

struct Scatter {
  double ratio = 1.0;  // reduced χ² of the stretches: 1 on average if the residuals are white
  double dof = 0.0;    // degrees of freedom of the ratio; 0: too few stretches to tell
  // Whether the ratio exceeds 1 by two of its standard deviations.
  [[nodiscard]] bool shows() const noexcept;
  // Factor for the variance of the mean; 1 unless shows(). A variation far beyond noise is not independent from stretch
  // to stretch: above kUnsteady the factor gives the spread of the stretches, not that of their mean.
  [[nodiscard]] double widens() const noexcept;
  static constexpr double kUnsteady = 9.0;  // ratio above which this holds and an operator is told
};

// Cuts blocks [from, to) into about twelve stretches of at least a period, the same for every channel; returns them by
// channel. `fits`: of the channels' sums about (omega, t_ref_ns) with `harmonics`. `scratch`: overwritten. O(blocks ·
// channels · H), allocates.
[[nodiscard]] std::vector<std::vector<PhasorStretch>> phasor_stretches(const Blocks& blocks, int from, int to,
                                                                       int harmonics,
                                                                       std::span<const HarmonicFit* const> fits,
                                                                       double omega, std::int64_t t_ref_ns,
                                                                       Totals& scratch);

// Scatter of one channel.
[[nodiscard]] Scatter scatter_of(std::span<const PhasorStretch> stretches) noexcept;

// Scatter of a weighted sum Σ_c w_c X_c; channels[c]: the stretches of channel c. A stretch counts if every channel
// with a weight other than zero is usable in it.
[[nodiscard]] Scatter scatter_of_sum(const Eigen::Ref<const Eigen::VectorXcd>& weights,
                                     std::span<const std::vector<PhasorStretch>> channels) noexcept;

}  // namespace dwell
