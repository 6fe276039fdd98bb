// What the transducers say of the chain: readings are linear in the table's motion, the deformations and the force.
//
//   o = G x,   x = (Y_0, d_1 … d_n, F),   Y_k = Y_0 + Σ_{l<=k} d_l
//
// o_c is channel c's phasor as displacement (transducer divided out, integrated) or as force on the ground. An absolute
// transducer at k has ones at Y_0, d_1 … d_k; one measuring y_at - y_relative_to has ones at the deformations between;
// a load cell has a one at F. Taking the deformations as the unknowns keeps every digit of a transducer mounted across
// an element. With as many channels as unknowns G is square and nothing is fitted; with more, weighted least squares
// gives the best x from all (docs/method.md, Identification).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// x = gain · o, from the channels that were available.
struct Gain {
  Eigen::MatrixXd gain;        // (n + 2) × channels; zero columns for channels not available
  Eigen::MatrixXd unresolved;  // (n + 2)²: I - gain·G; a linear function a·x is determined where a·unresolved = 0
  // Whether the channels determine function·x. Each sum is held against its own terms, so neither the units of x nor
  // the sizes of the function's entries decide: inertia of 1e12 N/m makes no missing force small. O(n²).
  [[nodiscard]] bool determines(const Eigen::Ref<const Eigen::VectorXcd>& function) const;
  // Whether that channel's reading has a part in function·x. O(n).
  [[nodiscard]] bool uses(const Eigen::Ref<const Eigen::VectorXcd>& function, Eigen::Index channel) const;
};

// G of a rig: channels × (n + 2); the column of F and the rows of auxiliary channels are zero where they mean nothing.
[[nodiscard]] Eigen::MatrixXd observation_matrix(const Rig& rig);

// Weighted least squares by a complete orthogonal decomposition. weights: 1/u of each channel (any common factor), 0
// for one not available. Allocates.
[[nodiscard]] Gain solve_observation(const Eigen::MatrixXd& G, const Eigen::VectorXd& weights);

}  // namespace dwell
