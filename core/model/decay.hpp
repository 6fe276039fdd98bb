// Predicts how long the transient of an identified chain lasts: time constant and poles, without allocation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <complex>
#include <span>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// With the table held, every transient is a sum of exp(λt), λ the eigenvalues of the chain (docs/method.md, Settling).
// The result equals that of slowest_decay_rate() in core/model/forward.hpp. The constructor allocates all memory.
class DecayRate {
 public:
  DecayRate(Boundary boundary, std::span<const double> masses);

  // Time constant 1 / min(-Re λ), s. Z: dynamic stiffness of each element (N/m, N·m/rad) at omega (rad/s). 0 for a
  // chain without masses. NaN if Z is not finite, the eigenvalues do not converge, or a mode does not decay. Also sets
  // poles(). O(n³).
  [[nodiscard]] double time_constant_s(std::span<const std::complex<double>> Z, double omega) noexcept;
  // Eigenvalues λ of the last time_constant_s(), rad/s, slowest decay first. A conjugate pair is given by its Im λ > 0.
  [[nodiscard]] std::span<const std::complex<double>> poles() const noexcept { return {poles_.data(), poles_.size()}; }

 private:
  Boundary boundary_;
  std::vector<double> masses_;
  Eigen::MatrixXd A_;  // state matrix of [ω y ; y'], 2n × 2n
  Eigen::EigenSolver<Eigen::MatrixXd> solver_;
  std::vector<std::complex<double>> poles_;
};

}  // namespace dwell
