// The unknowns that make the likelihood of a motion largest: Gauss-Newton on the Fisher information with Levenberg's
// damping. What the rig file states with an uncertainty enters with its prior.
//
//   minimize V(θ, x_0, b) + ½ Σ (θ_a / u_a)²;   Cov = (I + diag 1/u²)⁻¹
//
// Directions that no reading tells of, such as the common gauge of the biases, are null directions of the information.
// They stay where the start has them and are no part of the covariance. A parameter at its lower bound leaves the
// information while V still falls towards the bound: the data do not tell a noise or an intensity there from zero.
#pragma once

#include <Eigen/Core>
#include <exception>
#include <stop_token>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Nobody wants the result any more.
struct Stopped : std::exception {
  [[nodiscard]] const char* what() const noexcept override { return "nobody wants it any more"; }
};

struct FitLimits {
  Eigen::VectorXd lowest;  // per parameter; empty: none has one
  int passes = 40;         // of the filter at most, the two of the start included
  // The search ends where one more step would lower 2 V by less than this. The unknowns are then within √gain of their
  // standard deviations of the minimum: 1e-3 is 0.03 of them.
  double gain = 1e-3;
  double block_s = 0.0;  // as PassOptions
  std::stop_token stop{};
};

struct MotionFit {
  bool converged = false;  // also where the search stopped early with `left` below 0.1
  MotionUnknowns at;
  Pass pass;                     // at `at`
  double V = 0.0;                // with the priors' part
  Eigen::MatrixXd covariance;    // of (θ, initial, bias); 0 for what is held at its bound; empty: V was not finite
  Eigen::VectorXd undetermined;  // per unknown: part that lies in directions no reading tells of, 0 … 1
  double left = 0.0;             // by how much one more step would lower 2 V; NaN: V was not finite at the start
  int passes = 0;
};

// From a start; data and model must fit each other. A start without a finite V is not searched from. Allocates;
// thread-safe. Throws Stopped within a pass after limits.stop was requested.
[[nodiscard]] MotionFit fit_motion(const MotionModel& model, const MotionData& data, MotionUnknowns start,
                                   const FitLimits& limits);

}  // namespace dwell
