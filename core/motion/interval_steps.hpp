// What the state of a linear model does over an interval, exactly, with derivatives by the unknowns.
//
//   F(t) = exp(A t),   Q(t) = ∫_0^t F(u) g g' F(u)' du   (for unit intensity)
//
// Both are power series in t whose coefficients follow from F' = A F and Q' = A Q + Q A' + g g':
//
//   F_k = A F_{k-1} / k,   Q_{k+1} = (A Q_k + Q_k A') / (k + 1),   Q_1 = g g'
//
// and the same differentiated gives ∂F and ∂Q. Up to α t = 1/2 a series of 18 terms is exact to rounding; longer
// intervals are doubled. α = max(‖A⁴‖^(1/4), ‖A⁵‖^(1/5)) bounds the terms of the series as ‖A‖ does (Al-Mohy and Higham
// 2009, theorem 4.2). It is near the highest natural frequency ω_max; ‖A‖ is ω_max²/ω₀, which may be far larger. (Van
// Loan 1978 gets the same from one exponential of twice the size; the series gives any interval anew for one evaluation
// of a polynomial, which irregular stamps need.)
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/motion/motion_model.hpp"

namespace dwell {

// F, Q and their derivatives side by side.
struct Step {
  Eigen::MatrixXd all;  // m × 2 m (1 + derivatives)
  [[nodiscard]] auto F() const { return all.leftCols(all.rows()); }
  [[nodiscard]] auto Q() const { return all.middleCols(all.rows(), all.rows()); }
  // Of the d-th parameter that A depends on.
  [[nodiscard]] auto dF(Eigen::Index d) const { return all.middleCols(2 * (d + 1) * all.rows(), all.rows()); }
  [[nodiscard]] auto dQ(Eigen::Index d) const { return all.middleCols((2 * d + 3) * all.rows(), all.rows()); }
};

class IntervalSteps {
 public:
  explicit IntervalSteps(const LinearModel& model);

  // Per parameter: number of its derivative in a Step, or -1 where A does not depend on it.
  [[nodiscard]] const std::vector<int>& derivative_of() const noexcept { return derivative_of_; }

  // dt >= 0. Intervals that come again are remembered. Valid until the next call. Bound to one thread; allocates.
  [[nodiscard]] const Step& over(std::int64_t dt_ns);

 private:
  void fill(double dt_s, Step& out) const;
  void double_interval(Step& step) const;

  std::vector<int> derivative_of_;
  std::vector<Eigen::MatrixXd> terms_;  // coefficients of the series, each like Step::all
  double longest_s_ = 0.0;              // that the series covers
  std::unordered_map<std::int64_t, Step> known_;
  Step other_;
};

}  // namespace dwell
