// The unknowns that make the likelihood of a motion largest: Gauss-Newton on the Fisher information with Levenberg's
// damping, priors of what the rig file states added.
//
//   minimize V(θ, x_0, b) + ½ Σ (θ_a / u_a)²;   Cov = (I + diag 1/u²)⁻¹
//
// What no reading tells of (the gauge of the biases, say) are null directions of the information: they are left as they
// are and are no part of the covariance. A noise or intensity at its lower bound leaves the information: the data do
// not tell it from zero.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

struct FitLimits {
  Eigen::VectorXd lowest;  // per parameter; -∞: none
  int passes = 40;         // at most
  // Twice what V may still gain where it is said to be least: the square of what the unknowns are still off by, in
  // standard deviations. 1e-3: 0.03 of them.
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
  double left = 0.0;             // twice what V may still gain, as FitLimits::gain
  int passes = 0;
};

// From a start; data and model must fit each other. Allocates; thread-safe.
[[nodiscard]] MotionFit fit_motion(const MotionModel& model, const MotionData& data, MotionUnknowns start,
                                   const FitLimits& limits);

}  // namespace dwell
