// Free motion of a chain, exact for any step: x(t + dt) = exp(A dt) x(t) with the table held.
//
// An eigenvector basis would be cheaper per step but fails where modes coincide (critical damping), so the powers
// exp(A τ 2^k) are tabulated once by repeated squaring, and a step is the product of those that dt/τ has bits for, with
// a short Taylor series for the rest. Correct for every chain, defective or not; what is left is rounding, about 1e-16
// per τ = 0.03/‖A‖ (1e-9 after an hour without damping).
// Internal to core: it pulls in Eigen.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/chain.hpp"

namespace dwell {

class Propagator {
 public:
  // O(52 n³) and 52 (2n)² doubles: meant for n up to about 100.
  explicit Propagator(const Chain& chain);

  // Moves `state` = [y_1 … y_n, y_1' … y_n'] on by dt_s ≥ 0. About 35 products of 2n × 2n with a vector (1 µs at n =
  // 3); no allocation once called. Bound to one thread (it uses its own scratch).
  void apply(double dt_s, Eigen::VectorXd& state);

 private:
  void small_step(double dt_s);

  Eigen::MatrixXd A_;
  Eigen::VectorXd scale_;
  double tau_s_ = 0.0;
  std::vector<Eigen::MatrixXd> powers_;  // exp(A τ 2^k)
  bool vanishes_ = false;                // beyond the last of them nothing is left
  Eigen::VectorXd x_, term_, product_;
};

}  // namespace dwell
