// From the sources of error of a dwell to the covariance of all coefficients, and to the budget of each.
//
// A source is one vector: what one standard deviation of it does to (c_1, r_1, c_2, …) at once. The covariance is the
// sum of the outer products of these vectors (GUM Supplement 2, JCGM 102, 6.2), so an error that several coefficients
// share is neither counted twice nor lost, and the budget is read off source by source. To first order a source
// changes the unknowns x of the chain by δx and Z directly by δZ°:
//
//   δZ_k = (force_row_k - Z_k deformation_row_k)·δx / d_k + δZ°_k ,   δc = Re δZ ,   δr = Im δZ / ω - r δω / ω
//
// What all of them do to second order is one further source (core/chain/second_order.hpp). Effective degrees of
// freedom follow Welch and Satterthwaite (GUM, JCGM 100, G.4). docs/method.md, Uncertainty. Allocates.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "core/chain/chain_state.hpp"
#include "core/chain/evidence.hpp"
#include "core/chain/observed.hpp"
#include "core/chain/second_order.hpp"
#include "core/fit/scatter.hpp"
#include "core/result/dwell.hpp"

namespace dwell {

// One source of error and what one standard deviation of it does.
struct ErrorSource {
  std::string name;       // as the budget names it
  double dof;             // degrees of freedom behind it; infinity: type B
  Eigen::VectorXcd on_x;  // to x
  Eigen::VectorXcd on_Z;  // to Z directly, beside what it does through x
  double on_omega = 0.0;  // to ω, rad/s
  bool residual = false;  // of residuals: where these are not white it is widened, element by element
  int mass = 0;           // as SourceEffect
  double clock_u = 0.0;
  std::vector<ReadingError> readings = {};
  Eigen::VectorXcd bends_x = {};  // to x to second order, where an error turns phasors: -φ²/2 of them; empty: nothing
};

// What one standard deviation of a source of error does to [c_1, r_1, c_2, …] of all elements; 0 where not determined.
struct SourceEffect {
  Eigen::VectorXd on_coefficients;
  int mass = 0;                        // k of the mass that it is the uncertainty of; 0: of none
  double mass_u = 0.0;                 // that uncertainty, kg (kg·m²)
  double clock_u = 0.0;                // of the rate of the host's clock, which all times share; relative
  std::vector<ReadingError> readings;  // of scales, delays, filters, turnarounds and refreshed registers
};

// Call heed_scatter() first, then add() for every source, add_second_order() once, and read the results then.
class Propagation {
 public:
  // Both must outlive it.
  Propagation(const ChainState& chain, const ElementStates& elements);

  // How much the stiffness of the elements scatters from stretch to stretch: the sources of residuals are widened by
  // it. per_reading: ∂x/∂(a reading's phasor), (n + 2) × channels.
  void heed_scatter(const Eigen::MatrixXcd& per_reading, const std::vector<Evidence>& evidence);
  void add(const ErrorSource& source);
  // What all sources together do to second order, as one source of two vectors for each element.
  void add_second_order();

  // u(d) of element e (from 0), per component, m: |d| is held against it.
  [[nodiscard]] double deformation_u(Eigen::Index e) const;
  // Of (c_1, r_1, c_2, …).
  [[nodiscard]] const Eigen::MatrixXd& covariance() const noexcept { return covariance_; }
  // Source by source, in the order in which they were added.
  [[nodiscard]] std::vector<SourceEffect>& effects() noexcept { return effects_; }
  // δZ of all elements by a change of x, first order.
  [[nodiscard]] Eigen::VectorXcd on_Z(const Eigen::VectorXcd& change) const { return through_x_ * change; }
  // Coefficient i of (c_1, r_1, c_2, …) with that value: u, degrees of freedom, U95, whether it exceeds its u.
  [[nodiscard]] Coefficient coefficient(Eigen::Index i, double value) const;
  // Shares of the variances of c and r of element e, the largest first; sources of one name together.
  [[nodiscard]] std::vector<BudgetShare> budget(Eigen::Index e) const;

 private:
  struct Contribution {
    Eigen::VectorXd variance, dof;  // per coefficient
  };
  Contribution& add_effect(const std::string& name, double dof, SourceEffect effect);

  const ChainState& chain_;
  const ElementStates& elements_;
  Eigen::MatrixXcd through_x_, relative_deformation_rows_;  // ∂Z/∂x; ∂d/∂x relative to d
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd deformation_variance_;
  std::vector<Scatter> scatter_;     // per element
  std::vector<SecondOrder> second_;  // likewise
  std::vector<SourceEffect> effects_;
  std::map<std::string, Contribution> by_name_;
};

}  // namespace dwell
