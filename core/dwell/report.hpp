// Turns the fits of a dwell into its report: phasors of the motion, elements, frequency.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/chain/estimate.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/moving_errors.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/seen_modes.hpp"

namespace dwell {

struct ChannelResult {
  HarmonicFit fit;
  double dof = 0.0;                      // degrees of freedom behind the fit's covariance
  std::vector<PhasorStretch> stretches;  // of the dwell; empty before it has settled
  Scatter scatter;                       // of the stretches
  PhasorSlope slope;
  std::complex<double> taken_for_transient;  // see Evidence
  std::string withheld;                      // why its phasor must not be used now; empty: it may
  // Covariance of (Re, Im) of the reading's phasor by the unknown part of the transient, SI.
  Eigen::Matrix2d transient = Eigen::Matrix2d::Zero();
  double quantization_u = 0.0;  // of the reading, SI, either component: rounding by the device
  double refresh_u_s = 0.0;     // s: of the instants of a slowly refreshed register, independent of other channels
  UnevenReadings uneven;        // errors that grow with the motion
  double folded_u = 0.0;  // of the reading, SI, either component: harmonics that sampling folds onto the fundamental
  double turnaround_u_s = 0.0;  // s: of the instants by the turnaround …
  int transaction = -1;         // … common to this transaction (Transactions::of)
};

// Fills dwell.phasors, dwell.unstated and dwell.frequency_hz. omega, u_omega: rad/s. Allocates.
void report_phasors(const Rig& rig, const std::vector<ChannelResult>& channels, double omega, double u_omega,
                    Dwell& dwell);

// Fills dwell.elements, dwell.covariance and the elements' warnings and doubts. G: observation_matrix(rig). seen: the
// natural oscillations of the transient, compared with the identified chain's. Allocates.
void report_elements(const Rig& rig, const Eigen::MatrixXd& G, const std::vector<ChannelResult>& channels, double omega,
                     double u_omega, std::span<const SeenMode> seen, Dwell& dwell);

}  // namespace dwell
