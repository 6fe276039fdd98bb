// From the fits of a dwell to what is reported of it: phasors of the motion, elements, frequency.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/chain/estimate.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/seen_modes.hpp"

namespace dwell {

// One channel of a dwell.
struct ChannelResult {
  HarmonicFit fit;
  double dof = 0.0;                      // degrees of freedom behind the fit's covariance
  std::vector<PhasorStretch> stretches;  // of the dwell; empty: it has not settled
  Scatter scatter;                       // of these
  PhasorSlope slope;
  std::complex<double> absorbed;  // see Evidence
  std::string withheld;           // why it must not be used now; empty: it may
  // Covariance of (Re, Im) of the reading's phasor by what is not known of the transient, SI.
  Eigen::Matrix2d transient = Eigen::Matrix2d::Zero();
  double quantization_u = 0.0;  // of the reading, SI, either component: the device's rounding
  double refresh_u_s = 0.0;     // standard uncertainty of its instants by a register that is refreshed slowly, its own
  double folded_u = 0.0;        // of the reading, SI, either component: harmonics that sampling folds onto it
  double turnaround_u_s = 0.0;  // standard uncertainty of its instants …
  int transaction = -1;         // … shared by its transaction (Transactions::of)
};

// Fills dwell.phasors, dwell.unstated, and dwell.frequency_hz from omega and its uncertainty u_omega (rad/s).
// Allocates.
void report_phasors(const Rig& rig, const std::vector<ChannelResult>& channels, double omega, double u_omega,
                    Dwell& dwell);

// Fills dwell.elements, dwell.covariance and the elements' warnings and doubts. G: observation_matrix(rig). seen: the
// natural oscillations of the transient, which the chain identified is held against. Allocates.
void report_elements(const Rig& rig, const Eigen::MatrixXd& G, const std::vector<ChannelResult>& channels, double omega,
                     double u_omega, std::span<const SeenMode> seen, Dwell& dwell);

}  // namespace dwell
