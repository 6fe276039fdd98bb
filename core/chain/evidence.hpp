// Input of the estimate of the elements (core/chain/estimate.hpp): phasors and frequency as fitted to the samples of a
// dwell, with their uncertainties. Plain data.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "core/fit/harmonic_fit.hpp"
#include "core/fit/moving_errors.hpp"
#include "core/fit/scatter.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// One channel at the frequency of the drive. Uncertainties of phasors are per component (real or imaginary), SI.
struct Evidence {
  bool usable = false;
  std::string reason;                                    // why not usable
  std::array<std::complex<double>, kMaxHarmonics> X{};   // phasors of the reading at ω … Hω, SI
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (Re X_1, Im X_1), for white residuals
  double dof = 0.0;                                      // degrees of freedom of this covariance
  double widened = 1.0;                                  // factor on this covariance for the channel's own scatter
  std::vector<PhasorStretch> stretches;                  // phasors of parts of the dwell: scatter of each element
  PhasorSlope slope;
  std::complex<double>
      taken_for_transient;  // part of X_1: response to a change of the drive, perhaps taken for a transient
  Eigen::Matrix2d transient = Eigen::Matrix2d::Zero();  // covariance of X_1 by the uncertainty of the transient
  double quantization_u = 0.0;                          // of X_1, by the device's rounding
  double refresh_u_s = 0.0;                             // of the instants, by a slowly refreshed register
  UnevenReadings uneven;                                // errors that grow with the motion
  double folded_u = 0.0;                                // of X_1, by harmonics that sampling folds onto it
  double turnaround_u_s = 0.0;                          // of the instants, by the turnaround of the transaction
  int transaction = -1;  // lowest channel of those that share turnaround_u_s (Transactions::of); -1: no other does
};

struct Frequency {
  double omega = 0.0;    // rad/s
  double u = 0.0;        // rad/s, as measured or stated, by the host's clock
  double clock_u = 0.0;  // relative uncertainty of the clock rate
};

}  // namespace dwell
