// State of the chain from the channels that deliver, for the provisional coefficients while the rig settles. Does what
// solve_observation() of core/rig/observation.hpp does with all weights 1, without allocation after construction.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <complex>
#include <span>

#include "core/rig/rig.hpp"

namespace dwell {

class UsableObservation {
 public:
  // G: observation_matrix(rig).
  UsableObservation(const Rig& rig, const Eigen::MatrixXd& G);

  // Marks channel c as not delivering, or as observing o (displacement or force on the ground).
  void leave_out(int c) noexcept;
  void observe(int c, std::complex<double> o) noexcept;
  // Writes (Y_0, d_1 … d_n, F) into x. false: the channels do not determine x, do not use it. O(channels · n² + n³).
  [[nodiscard]] bool solve(Eigen::Ref<Eigen::VectorXcd> x) noexcept;

 private:
  Eigen::MatrixXd G_, normal_, inverse_;
  Eigen::VectorXd uses_;  // per channel, 1 or 0
  Eigen::VectorXcd observed_, right_;
  Eigen::Index unknowns_;  // entries of x that must be determined: all if clamped, all but F if free
};

}  // namespace dwell
