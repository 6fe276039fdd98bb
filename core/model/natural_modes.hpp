// Natural modes of a chain with the table held, and the derivatives of their poles by coefficients and masses.
//
//   (λ² M + λ C + K) φ = 0,   N = φ'(2λ M + C) φ,   δ_e = φ_e - φ_{e-1} (table and ground: 0)
//   ∂λ/∂c_e = -δ_e² / N,   ∂λ/∂r_e = -λ δ_e² / N,   ∂λ/∂m_k = -λ² φ_k² / N
//
// M, C and K are symmetric, so the left eigenvector is φ' (transposed, not conjugated). First-order perturbation gives
// the derivatives (Lancaster, Lambda-Matrices and Vibrating Systems, 1966, section 6).
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/model/chain.hpp"

namespace dwell {

struct NaturalMode {
  std::complex<double> pole;      // λ, rad/s, Im > 0
  Eigen::VectorXcd by_stiffness;  // ∂λ/∂c_e per element, 1/s per N/m; ∂λ/∂r_e = λ ∂λ/∂c_e
  Eigen::VectorXcd by_mass;       // ∂λ/∂m_k per mass, 1/s per kg
  Eigen::VectorXcd shape;         // φ_1 … φ_n, scale arbitrary
};

// All modes that oscillate (Im λ > 0). The chain must have no fault(); coefficients may be negative. Empty if the
// eigenvalues cannot be computed. O(n³), allocates; thread-safe.
[[nodiscard]] std::vector<NaturalMode> natural_modes(const Chain& chain);

}  // namespace dwell
