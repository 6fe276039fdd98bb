// What is known of each channel and of the frequency once a dwell's samples are fitted: all that the estimate of the
// elements (core/chain/estimate.hpp) is made from. Plain data.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <string>
#include <vector>

#include "core/fit/harmonic_fit.hpp"
#include "core/fit/scatter.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// What is known of one channel at the frequency of the drive.
struct Evidence {
  bool usable = false;
  std::string reason;                                    // why not
  std::array<std::complex<double>, kMaxHarmonics> X{};   // phasors of the reading at ω … Hω, SI
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of (Re X_1, Im X_1), white residuals
  double dof = 0.0;                                      // degrees of freedom behind that covariance
  double widened = 1.0;                                  // by what it is larger for the channel's own scatter
  std::vector<PhasorStretch> stretches;                  // give the scatter of each element
  PhasorSlope slope;
  std::complex<double>
      absorbed;  // of X_1: the answer to a change of the drive that may have been taken for a transient
  Eigen::Matrix2d transient = Eigen::Matrix2d::Zero();  // covariance by what is not known of the transient
  double quantization_u = 0.0;                          // of the reading, either component, the device's rounding
  double refresh_u_s = 0.0;                             // of the instants, by a slowly refreshed register, its own
  double folded_u = 0.0;                                // of the reading, either component, harmonics folded onto it
  double turnaround_u_s = 0.0;                          // standard uncertainty of the instants …
  int transaction = -1;  // … shared by all channels of one transaction (Transactions::of); -1: by none
};

struct Frequency {
  double omega = 0.0;    // rad/s
  double u = 0.0;        // rad/s, as measured or stated, against the host's clock
  double clock_u = 0.0;  // relative, of the clock
};

}  // namespace dwell
