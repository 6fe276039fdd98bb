// The chain as a first-order system, scaled so that its matrix is well balanced. The propagator and the eigenvalue
// problems share it. Internal to core: it pulls in Eigen.
#pragma once

#include <Eigen/Core>

#include "core/model/chain.hpp"

namespace dwell {

// x' = A x with x = [ω₀ √m_k y_k ; √m_k y_k'], the table held at zero. ω₀ = √(max K_kk/m_k) makes both halves
// comparable. √m_k makes the stiffness block symmetric; without it the entries of A would span several orders of
// magnitude.
struct StateMatrix {
  Eigen::MatrixXd A;      // 2n × 2n
  Eigen::VectorXd scale;  // x = scale ∘ [y ; y']
};

[[nodiscard]] StateMatrix state_matrix(const Chain& chain);

}  // namespace dwell
