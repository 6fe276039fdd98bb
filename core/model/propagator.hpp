// Moves the free motion of a chain on by any step, exactly: x(t + dt) = exp(A dt) x(t) with the table held.
//
// The powers exp(A τ 2^k), τ = 0.03/‖A‖, are tabulated once by repeated squaring. A step multiplies the powers that the
// bits of dt/τ select; a short Taylor series covers the rest. An eigenvector basis would be cheaper, but it fails where
// modes coincide (critical damping). The only error is rounding: about 1e-16 per τ (1e-9 after an hour without
// damping). Internal to core: it pulls in Eigen.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/chain.hpp"

namespace dwell {

class Propagator {
 public:
  // Time O(52 n³), memory 52 (2n)² doubles: meant for n up to about 100. The chain must have no fault().
  explicit Propagator(const Chain& chain);

  // Moves `state` = [y_1 … y_n, y_1' … y_n'] on by dt_s ≥ 0. NaN from 2^52 τ on, unless the transient has vanished by
  // then. About 35 products of a 2n × 2n matrix and a vector (1 µs at n = 3). Only the first call allocates. Bound to
  // one thread.
  void apply(double dt_s, Eigen::VectorXd& state);

 private:
  void small_step(double dt_s);

  Eigen::MatrixXd A_;
  Eigen::VectorXd scale_;
  double tau_s_ = 0.0;
  std::vector<Eigen::MatrixXd> powers_;  // exp(A τ 2^k)
  bool vanishes_ = false;                // a step longer than these powers leaves zero
  Eigen::VectorXd x_, term_, product_;
};

}  // namespace dwell
