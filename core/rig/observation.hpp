// Observation model: gives the state x of the chain from the readings of all channels, by weighted least squares.
//
//   o = G x,   x = (Y_0, d_1 … d_n, F),   Y_k = Y_0 + Σ_{l<=k} d_l
//
// o_c is channel c's phasor as displacement (transducer divided out, integrated) or as force on the ground. The row of
// an absolute transducer at k has ones at Y_0, d_1 … d_k. The row of a transducer that measures y_at - y_relative_to
// has ±1 at the deformations between both places. The row of a load cell has a one at F. The deformations are the
// unknowns, so a transducer mounted across an element keeps all its digits (docs/method.md, Identification).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// Solution of o = G x for the channels that were available: x = gain · o.
struct Gain {
  Eigen::MatrixXd gain;            // (n + 2) × channels; zero columns for channels not available
  Eigen::MatrixXd null_projector;  // (n + 2)²: I - gain·G; a linear function a·x is determined if a·null_projector = 0
  // Whether the channels determine function·x. Each sum is compared with its own terms. Units and sizes therefore do
  // not matter: a missing force is still noticed beside an inertia of 1e12 N/m. O(n²).
  [[nodiscard]] bool determines(const Eigen::Ref<const Eigen::VectorXcd>& function) const;
  // Whether function·x depends on that channel's reading. O(n).
  [[nodiscard]] bool uses(const Eigen::Ref<const Eigen::VectorXcd>& function, Eigen::Index channel) const;
};

// G of a rig, channels × (n + 2). Rows of auxiliary channels are zero; so is the column of F without a load cell.
[[nodiscard]] Eigen::MatrixXd observation_matrix(const Rig& rig);

// Weighted least squares by a complete orthogonal decomposition. weights: 1/u of each channel, up to a common factor; 0
// for a channel that is not available. Allocates.
[[nodiscard]] Gain solve_observation(const Eigen::MatrixXd& G, const Eigen::VectorXd& weights);

}  // namespace dwell
