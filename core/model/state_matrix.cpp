#include "core/model/state_matrix.hpp"

#include <cmath>

namespace dwell {

StateMatrix state_matrix(const Chain& chain) {
  const int n = chain.mass_count();
  const int elements = chain.element_count();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  // Element e joins row e-1 to row e. Row -1 is the table, row n the ground; both are held.
  for (int e = 0; e < elements; ++e) {
    const auto i = static_cast<std::size_t>(e);
    for (const int a : {e - 1, e}) {
      if (a < 0 || a >= n) continue;
      for (const int b : {e - 1, e}) {
        if (b < 0 || b >= n) continue;
        const double sign = a == b ? 1.0 : -1.0;
        const double root =
            std::sqrt(chain.masses[static_cast<std::size_t>(a)] * chain.masses[static_cast<std::size_t>(b)]);
        K(a, b) += sign * chain.stiffness[i] / root;
        C(a, b) += sign * chain.damping[i] / root;
      }
    }
  }
  StateMatrix out;
  double omega0 = n > 0 ? std::sqrt(K.diagonal().cwiseAbs().maxCoeff()) : 1.0;
  if (!(omega0 > 0.0)) omega0 = 1.0;
  out.A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  out.A.topRightCorner(n, n) = omega0 * Eigen::MatrixXd::Identity(n, n);
  out.A.bottomLeftCorner(n, n) = -K / omega0;
  out.A.bottomRightCorner(n, n) = -C;
  out.scale.resize(2 * n);
  for (int k = 0; k < n; ++k) {
    const double root = std::sqrt(chain.masses[static_cast<std::size_t>(k)]);
    out.scale[k] = omega0 * root;
    out.scale[n + k] = root;
  }
  return out;
}

}  // namespace dwell
