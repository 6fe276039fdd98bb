// The unknowns that make the likelihood of a motion largest: Gauss-Newton on the Fisher information with Levenberg's
// damping. What the rig file states with an uncertainty enters with its prior.
//
//   minimize V(θ, x_0, b) + ½ Σ (θ_a / u_a)²;   Cov = (I + diag 1/u²)⁻¹
//
// Directions that no reading tells of, such as the common gauge of the biases, are null directions of the information.
// They stay where the start has them and are no part of the covariance. A noise or an intensity at its lower bound
// leaves the information, for the data do not tell it from zero.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

struct FitLimits {
  Eigen::VectorXd lowest;  // per parameter; -∞: none
  int passes = 40;         // at most
  // The search ends where one more step would lower 2 V by less than this. The unknowns are then within √gain of their
  // standard deviations of the minimum: 1e-3 is 0.03 of them.
  double gain = 1e-3;
  double block_s = 0.0;  // as PassOptions
};

struct MotionFit {
  bool converged = false;
  MotionUnknowns at;
  Pass pass;                     // at `at`
  double V = 0.0;                // with the priors' part
  Eigen::MatrixXd covariance;    // of (θ, initial, bias)
  Eigen::VectorXd undetermined;  // per unknown: part that lies in directions no reading tells of, 0 … 1
  double left = 0.0;             // by how much one more step would lower 2 V; compare FitLimits::gain
  int passes = 0;
};

// From a start; data and model must fit each other. Allocates; thread-safe.
[[nodiscard]] MotionFit fit_motion(const MotionModel& model, const MotionData& data, MotionUnknowns start,
                                   const FitLimits& limits);

}  // namespace dwell
