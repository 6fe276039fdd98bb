// Force f and deformation d of every element at one harmonic of the drive, as linear functions of the unknowns
// x = (Y_0, d_1 … d_n, F) of core/rig/observation.hpp. Internal to core. Allocates.
#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/rig/rig.hpp"

namespace dwell {

// Row a with a·x = f_k, N: the force of element k (1 …) on mass k-1; for k = n+1 the force on the ground. inertia: -s²
// for a motion exp(st), so ω² in steady motion.
template <class Scalar>
[[nodiscard]] Eigen::VectorXcd force_row(const Rig& rig, int k, Scalar inertia) {
  const int n = rig.mass_count();
  Eigen::VectorXcd row = Eigen::VectorXcd::Zero(n + 2);
  if (rig.boundary == Boundary::clamped) row(n + 1) = k == n + 1 ? 1.0 : -1.0;
  if (k == n + 1) return row;
  double beyond = 0.0;  // total mass that moves with d_l: Σ_{i >= max(k, l)} m_i
  for (int l = n; l >= 1; --l) {
    if (l >= k) beyond += rig.masses[static_cast<std::size_t>(l - 1)];
    row(l) = inertia * beyond;
  }
  row(0) = inertia * beyond;
  return row;
}

// Row a with a·x = d_k, the deformation of element k, m.
[[nodiscard]] inline Eigen::VectorXcd deformation_row(int n, int k) {
  Eigen::VectorXcd row = Eigen::VectorXcd::Zero(n + 2);
  if (k <= n)
    row(k) = 1.0;
  else
    row.head(n + 1).setOnes();  // Y_n (n = 0: Y_0)
  return row;
}

struct ChainState {
  const Rig& rig;
  int n;         // masses
  double omega;  // rad/s, of this harmonic
  Eigen::VectorXcd x;

  [[nodiscard]] std::complex<double> Y(int k) const { return x.head(k + 1).sum(); }
  [[nodiscard]] Eigen::VectorXcd force_row(int k) const { return dwell::force_row(rig, k, omega * omega); }
  [[nodiscard]] Eigen::VectorXcd deformation_row(int k) const { return dwell::deformation_row(n, k); }
};

// All elements of a chain in this state: f = force_rows·x, d = deformation_rows·x, Z = f/d.
struct ElementStates {
  explicit ElementStates(const ChainState& chain)
      : force_rows(chain.rig.element_count(), chain.n + 2),
        deformation_rows(chain.rig.element_count(), chain.n + 2),
        d(chain.rig.element_count()),
        Z(chain.rig.element_count()) {
    for (Eigen::Index e = 0; e < Z.size(); ++e) {
      const int k = static_cast<int>(e) + 1;
      force_rows.row(e) = chain.force_row(k).transpose();
      deformation_rows.row(e) = chain.deformation_row(k).transpose();
      const std::complex<double> f = force_rows.row(e).transpose().cwiseProduct(chain.x).sum();
      d(e) = deformation_rows.row(e).transpose().cwiseProduct(chain.x).sum();
      Z(e) = f / d(e);
    }
  }

  Eigen::MatrixXcd force_rows, deformation_rows;  // elements × (n + 2)
  Eigen::VectorXcd d, Z;                          // m and N/m, per element
};

}  // namespace dwell
