// How long a chain remembers: the slowest decay rate of the identified chain, without allocation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <complex>
#include <span>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// The eigenvalues of the chain with the table held are what its transients are made of (docs/method.md, Settling). The
// same as slowest_decay_rate() of core/model/forward.hpp, on memory that is there from construction.
class DecayRate {
 public:
  DecayRate(Boundary boundary, std::span<const double> masses);

  // Time constant 1 / min(-Re λ) in s of the chain with dynamic stiffnesses Z (N/m) at omega (rad/s). 0 for a chain
  // without masses; NaN where Z is not finite or the chain would not decay. O(n³), no allocation.
  [[nodiscard]] double time_constant_s(std::span<const std::complex<double>> Z, double omega) noexcept;
  // The eigenvalues behind the last time_constant_s(), slowest first, of conjugate pairs the one with Im > 0; rad/s.
  [[nodiscard]] std::span<const std::complex<double>> poles() const noexcept { return {poles_.data(), poles_.size()}; }

 private:
  Boundary boundary_;
  std::vector<double> masses_;
  Eigen::MatrixXd A_;  // of [ω y ; y'], 2n × 2n
  Eigen::EigenSolver<Eigen::MatrixXd> solver_;
  std::vector<std::complex<double>> poles_;
};

}  // namespace dwell
