// How far one natural oscillation is from being one of the identified chain (docs/method.md, Cross-check).
//
// The equations that give the elements hold for any motion exp(st), so for each natural oscillation too, the table
// being at rest in it: with its pole λ for jω and its amplitudes for the phasors,
//
//   R_k = f_k(λ) - (c_k + λ r_k) d_k ,   f_k = -λ² Σ_{i>=k} m_i Y_i (- F);  k = n+1: F
//
// is the force that element k lacks; of the right model it is zero within the uncertainty. R contains both what the
// eigenvalues tell (the combination of the R_k by the chain's own shape does not depend on the amplitudes to first
// order) and what the shape tells.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "core/base/complex.hpp"
#include "core/chain/estimate.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/seen_modes.hpp"

namespace dwell {

class ModeResidual {
 public:
  // omega: of the drive at which `identified` was found, rad/s. An element takes part if it is identifiable and all its
  // channels are in the fit. Allocates; O(channels² · elements).
  ModeResidual(const Rig& rig, const ElementsResult& identified, double omega, const SeenMode& seen);

  // The elements that take part, from 0.
  [[nodiscard]] const std::vector<Eigen::Index>& elements() const noexcept { return elements_; }
  // R'Cov⁻¹R and its degrees of freedom, two an element; 0 and 0 where nothing takes part.
  [[nodiscard]] double chi2() const noexcept { return chi2_; }
  [[nodiscard]] int freedom() const noexcept { return 2 * static_cast<int>(elements_.size()); }
  // Probability of as much by chance.
  [[nodiscard]] double by_chance() const noexcept;
  // The same for the pole alone. Σ δ_k R_k is the work that the lacking forces do in the chain's own mode: δ_k are its
  // deformations, shape its displacements of masses 1 … n, of any size. To first order no amplitude changes that sum.
  // It has two degrees of freedom, by_chance() two an element: this test is the sharper one where the pole contradicts
  // and the shape does not. 1 where an element does not take part. Allocates; O(elements²).
  [[nodiscard]] double pole_by_chance(const Eigen::VectorXcd& shape) const;
  // The element that contradicts most by itself, as a position in elements(), and its own χ² of two.
  [[nodiscard]] Eigen::Index worst(double* chi2) const noexcept;
  // Difference (δc, δr) of element elements()[i], by the oscillation minus by the drive, from δc + λ δr = R/d; and its
  // covariance, in which what moves both alike cancels.
  [[nodiscard]] Eigen::Vector2d change(Eigen::Index i) const noexcept;
  [[nodiscard]] Eigen::Matrix2d change_covariance(Eigen::Index i) const noexcept;

  // What a unit of a single fault of the rig file makes of R: (Re, Im) of each element that takes part, in the units of
  // weighted(). A mass and a reading relative to what is stated, an instant in s, a spring or damper between two places
  // (0: the table, kGround: the ground) in N/m or N·s/m.
  [[nodiscard]] Eigen::VectorXd by_mass(Eigen::Index mass) const;
  [[nodiscard]] Eigen::VectorXd by_scale(Eigen::Index channel) const;
  [[nodiscard]] Eigen::VectorXd by_delay(Eigen::Index channel) const;
  [[nodiscard]] Eigen::VectorXd by_connection(int from, int to, bool damps) const;
  // a'Cov⁻¹b.
  [[nodiscard]] double product(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    return a.dot(factor_.solve(b));
  }
  [[nodiscard]] const Eigen::VectorXd& force() const noexcept { return force_; }

 private:
  // Rows: R by each channel's amplitude, at a pole near the seen one.
  [[nodiscard]] Eigen::MatrixXcd by_amplitude(Complex pole) const;
  [[nodiscard]] Eigen::MatrixXd covariance_of_effects() const;
  [[nodiscard]] double deformation_variance(Eigen::Index i) const;
  [[nodiscard]] double second_order(Eigen::Index i) const;
  // As (Re, Im) of each element over its scale.
  [[nodiscard]] Eigen::VectorXd in_pairs(const Eigen::VectorXcd& forces) const;
  // δZ(jω) of each element that takes part as the change of its force at the pole.
  [[nodiscard]] Eigen::VectorXcd at_pole(const Eigen::VectorXcd& dZ) const;
  [[nodiscard]] Complex Y(int place) const;         // of the oscillation; the ground is at rest
  [[nodiscard]] Complex steady_Y(int place) const;  // of the steady motion

  // Given, and to outlive this.
  const Rig& rig_;
  const ElementsResult& identified_;
  double omega_;
  const SeenMode& seen_;
  std::vector<Eigen::Index> elements_;
  Eigen::VectorXcd x_, deformation_;  // of the oscillation
  Eigen::VectorXcd by_pole_;          // ∂R/∂λ
  Eigen::VectorXd scale_;             // N, per element: the size of its terms
  Eigen::VectorXd force_;             // R in pairs
  Eigen::MatrixXd covariance_;        // of force_
  Eigen::LDLT<Eigen::MatrixXd> factor_;
  double chi2_ = 0.0;
};

}  // namespace dwell
