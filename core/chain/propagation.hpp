// Computes the covariance of all coefficients, and the budget of each, from the error sources of a dwell.
//
// A source is one vector: the change of (c_1, r_1, c_2, …) by one standard deviation. The covariance is the sum of the
// outer products of these vectors (GUM Supplement 2, JCGM 102, 6.2). So an error that several coefficients share is
// counted exactly once, and the budget follows source by source. To first order a source changes the unknowns x of the
// chain by δx, and Z directly by δZ°:
//
//   δZ_k = (force_row_k - Z_k deformation_row_k)·δx / d_k + δZ°_k ,   δc = Re δZ ,   δr = Im δZ / ω - r δω / ω
//
// The second-order effect of all sources is one further source (core/chain/second_order.hpp). Effective degrees of
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

// One error source, and the changes by one standard deviation of it.
struct ErrorSource {
  std::string name;       // as in the budget
  double dof;             // degrees of freedom; infinity: type B
  Eigen::VectorXcd on_x;  // first-order change of x
  Eigen::VectorXcd on_Z;  // change of Z that does not come through x
  double on_omega = 0.0;  // change of ω, rad/s
  bool residual = false;  // noise of residuals: widened per element if the residuals are not white
  int mass = 0;           // as in SourceEffect
  double clock_u = 0.0;
  std::vector<ReadingError> readings = {};
  Eigen::VectorXcd bends_x = {};        // second-order change of x: -φ²/2 of the phasors turned by φ; empty: none
  SourceKind kind = SourceKind::other;  // these as in BudgetShare
  std::string channel = {};
  std::string device = {};
};

// Effect of one standard deviation of a source, member by member as in CoefficientError.
struct SourceEffect {
  Eigen::VectorXd on_coefficients;
  int mass = 0;
  double mass_u = 0.0;
  double clock_u = 0.0;
  std::vector<ReadingError> readings;
};

// Order of calls: set_scatter(), add() for every source, add_second_order() once, then the results.
class Propagation {
 public:
  // chain and elements must outlive this object.
  Propagation(const ChainState& chain, const ElementStates& elements);

  // Determines for each element how much Z scatters from stretch to stretch; this widens the sources with `residual`.
  // per_reading: ∂x/∂(a reading's phasor), (n + 2) × channels.
  void set_scatter(const Eigen::MatrixXcd& per_reading, const std::vector<Evidence>& evidence);
  void add(const ErrorSource& source);
  // Adds the second-order effect of all sources together: two vectors per element, named "errors to second order".
  void add_second_order();

  // u(d) of element e (from 0), m, per component: the uncertainty to compare |d| with.
  [[nodiscard]] double deformation_u(Eigen::Index e) const;
  // Covariance of (c_1, r_1, c_2, …).
  [[nodiscard]] const Eigen::MatrixXd& covariance() const noexcept { return covariance_; }
  // The effects of all sources, in the order in which they were added.
  [[nodiscard]] std::vector<SourceEffect>& effects() noexcept { return effects_; }
  // First-order change δZ of all elements by a change of x.
  [[nodiscard]] Eigen::VectorXcd on_Z(const Eigen::VectorXcd& change) const { return through_x_ * change; }
  // Coefficient i of (c_1, r_1, c_2, …): `value` with its u, degrees of freedom, U95 and significance.
  [[nodiscard]] Coefficient coefficient(Eigen::Index i, double value) const;
  // Shares of the variances of c and r of element e, largest first; sources of the same name count together.
  [[nodiscard]] std::vector<BudgetShare> budget(Eigen::Index e) const;

 private:
  struct Contribution {
    Eigen::VectorXd variance, dof;  // per coefficient
    SourceKind kind = SourceKind::other;
    std::string channel = {}, device = {};
    int mass = 0;
  };
  Contribution& add_effect(const std::string& name, double dof, SourceEffect effect);

  const ChainState& chain_;
  const ElementStates& elements_;
  Eigen::MatrixXcd through_x_, relative_deformation_rows_;  // ∂Z/∂x; ∂d/∂x relative to d
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd deformation_variance_;
  std::vector<Scatter> scatter_;     // per element
  std::vector<SecondOrder> second_;  // per element
  std::vector<SourceEffect> effects_;
  std::map<std::string, Contribution> by_name_;
};

}  // namespace dwell
