// The poles of an identified chain and how long its transient lasts, without allocation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <complex>
#include <limits>
#include <span>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// With the table held, every transient is a sum of exp(λt), λ the eigenvalues of the chain (docs/method.md, Settling).
// The result equals that of slowest_decay_rate() in core/model/forward.hpp. The constructor allocates all memory.
class ChainEigenvalues {
 public:
  ChainEigenvalues(Boundary boundary, std::span<const double> masses);

  // Z: dynamic stiffness of each element (N/m, N·m/rad) at omega (rad/s). O(n³).
  void update(std::span<const std::complex<double>> Z, double omega) noexcept;
  // 1 / min(-Re λ), s; 0 for a chain without masses; infinite if a mode does not decay. NaN if Z is not finite or the
  // eigenvalues do not converge.
  [[nodiscard]] double time_constant_s() const noexcept { return time_constant_s_; }
  // The eigenvalues λ, rad/s, slowest decay first. A conjugate pair is given by its Im λ > 0.
  [[nodiscard]] std::span<const std::complex<double>> values() const noexcept {
    return {eigenvalues_.data(), eigenvalues_.size()};
  }

 private:
  Boundary boundary_;
  std::vector<double> masses_;
  Eigen::MatrixXd A_;  // state matrix of [ω y ; y'], 2n × 2n
  Eigen::EigenSolver<Eigen::MatrixXd> solver_;
  std::vector<std::complex<double>> eigenvalues_;
  double time_constant_s_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace dwell
