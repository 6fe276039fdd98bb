// The state of the chain from the transducers that deliver, without allocation: what gives provisional coefficients
// while settling. As solve_observation() of core/rig/observation.hpp with weights of one, on memory that is there from
// construction.
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

  // Takes channel c as not delivering, or as observing o (displacement or force on the ground).
  void leave_out(int c) noexcept;
  void observe(int c, std::complex<double> o) noexcept;
  // x = (Y_0, d_1 … d_n, F) into x. false: the channels that deliver do not determine it. O(channels · n² + n³).
  [[nodiscard]] bool solve(Eigen::Ref<Eigen::VectorXcd> x) noexcept;

 private:
  Eigen::MatrixXd G_, normal_, inverse_;
  Eigen::VectorXd uses_;  // per channel, 1 or 0
  Eigen::VectorXcd observed_, right_;
  Eigen::Index unknowns_;  // of x that must be determined: without F for a free chain
};

}  // namespace dwell
