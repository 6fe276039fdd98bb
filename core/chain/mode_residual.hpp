// Tests whether a natural oscillation in the data belongs to the identified chain (docs/method.md, Cross-check).
//
// The equations that give the elements hold for any motion exp(st). A natural oscillation is such a motion, with the
// table at rest: its pole λ replaces jω, its amplitudes replace the phasors. The force that element k lacks is
//
//   R_k = f_k(λ) - (c_k + λ r_k) d_k ,   f_k = -λ² Σ_{i>=k} m_i Y_i (- F);  k = n+1: F .
//
// For the right model all R_k are zero within their uncertainty. R tests the eigenvalues as well as the mode shape.
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
  // omega: of the drive from which `identified` comes, rad/s. An element takes part if it is determined
  // (ElementsResult::u) and all its channels are in the fit of `seen`. One that is withheld as negative has its
  // equations too: without them any single fault would explain the few that remain. pole_widens: factor of the variance
  // of the pole, since its errors are normal near it alone; overstated_distance(). Allocates; O(channels² · elements).
  ModeResidual(const Rig& rig, const ElementsResult& identified, double omega, const SeenMode& seen,
               double pole_widens = 1.0);

  // Indices of the elements that take part, from 0, ascending.
  [[nodiscard]] const std::vector<Eigen::Index>& elements() const noexcept { return elements_; }
  // χ² = R'Cov⁻¹R and its degrees of freedom, two per element; 0 and 0 if no element takes part.
  [[nodiscard]] double chi2() const noexcept { return chi2_; }
  [[nodiscard]] int freedom() const noexcept { return 2 * static_cast<int>(elements_.size()); }
  // Probability that χ² is as large by chance.
  [[nodiscard]] double by_chance() const noexcept;
  // The same for the pole alone, by the work Σ δ_k R_k of the lacking forces in the chain's own mode. shape:
  // displacements of masses 1 … n in this mode, of any size; δ_k: its deformations. To first order the amplitudes do
  // not change the sum. It has two degrees of freedom in all, so this is the sharper test if the pole contradicts and
  // the shape does not. Returns 1 if an element does not take part. Allocates; O(elements²).
  [[nodiscard]] double pole_by_chance(const Eigen::VectorXcd& shape) const;
  // Position in elements() of the element with the largest χ² of its own, and this χ² (two degrees of freedom).
  [[nodiscard]] Eigen::Index worst(double* chi2) const noexcept;
  // (δc, δr) of element elements()[i], by the oscillation minus by the drive, from δc + λ δr = R/d; N/m, N·s/m. In its
  // covariance errors that change both alike cancel.
  [[nodiscard]] Eigen::Vector2d change(Eigen::Index i) const noexcept;
  [[nodiscard]] Eigen::Matrix2d change_covariance(Eigen::Index i) const noexcept;

  // Change of scaled_residual() by a single fault of the rig file, per unit: a mass or a reading relative to its stated
  // size, a delay in s, a spring in N/m or damper in N·s/m between two places (0: the table, kGround: the ground).
  [[nodiscard]] Eigen::VectorXd by_mass(Eigen::Index mass) const;
  [[nodiscard]] Eigen::VectorXd by_scale(Eigen::Index channel) const;
  [[nodiscard]] Eigen::VectorXd by_delay(Eigen::Index channel) const;
  [[nodiscard]] Eigen::VectorXd by_connection(int from, int to, bool damps) const;
  // a'Cov⁻¹b, Cov of scaled_residual().
  [[nodiscard]] double product(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    return a.dot(factor_.solve(b));
  }
  // (Re R_k, Im R_k) of each element that takes part, divided by the size of its terms, |f_k| + |Z_k d_k|.
  [[nodiscard]] const Eigen::VectorXd& scaled_residual() const noexcept { return scaled_residual_; }

 private:
  // ∂R/∂(amplitude of each channel) at `pole`: elements() × channels, N per unit of the reading.
  [[nodiscard]] Eigen::MatrixXcd by_amplitude(Complex pole) const;
  [[nodiscard]] Eigen::MatrixXd covariance_of_effects() const;
  [[nodiscard]] double deformation_variance(Eigen::Index i) const;
  [[nodiscard]] double second_order(Eigen::Index i) const;
  // (Re, Im) of each element's force, divided by its scale_.
  [[nodiscard]] Eigen::VectorXd in_pairs(const Eigen::VectorXcd& forces) const;
  // Change of each element's force at the pole by a change δZ(jω) of all elements; N.
  [[nodiscard]] Eigen::VectorXcd at_pole(const Eigen::VectorXcd& dZ) const;
  [[nodiscard]] Complex Y(int place) const;         // amplitude of the oscillation, 0 at kGround
  [[nodiscard]] Complex steady_Y(int place) const;  // phasor of the steady motion

  // These references must outlive this object.
  const Rig& rig_;
  const ElementsResult& identified_;
  double omega_;
  const SeenMode& seen_;
  std::vector<Eigen::Index> elements_;
  Eigen::VectorXcd x_, deformation_;  // state and deformations of the oscillation
  Eigen::VectorXcd by_pole_;          // ∂R/∂λ
  Eigen::VectorXd scale_;             // N, per element: |f_k| + |Z_k d_k|
  Eigen::VectorXd scaled_residual_;   // in_pairs(R)
  Eigen::MatrixXd near_;              // covariance of scaled_residual_, the pole's errors taken as normal
  Eigen::MatrixXd covariance_;        // what scaled_residual_ is tested by: with the pole's variance widened
  Eigen::LDLT<Eigen::MatrixXd> factor_;
  double chi2_ = 0.0;
};

}  // namespace dwell
