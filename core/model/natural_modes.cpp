#include "core/model/natural_modes.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/base/complex.hpp"
#include "core/model/state_matrix.hpp"

namespace dwell {

std::vector<NaturalMode> natural_modes(const Chain& chain) {
  using Eigen::Index;
  std::vector<NaturalMode> modes;
  const Index n = chain.mass_count(), elements = chain.element_count();
  if (n == 0) return modes;
  const StateMatrix state = state_matrix(chain);
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(state.A);
  if (solver.info() != Eigen::Success) return modes;
  for (Index i = 0; i < 2 * n; ++i) {
    const Complex pole = solver.eigenvalues()(i);
    if (!(pole.imag() > 0)) continue;
    const Eigen::VectorXcd vector = solver.eigenvectors().col(i);
    Eigen::VectorXcd shape(n + 2);  // table, masses, ground
    shape.setZero();
    for (Index k = 0; k < n; ++k) shape(k + 1) = vector(k) / state.scale(k);
    NaturalMode mode{pole, Eigen::VectorXcd(elements), Eigen::VectorXcd(n), shape.segment(1, n)};
    Complex norm{};
    for (Index e = 0; e < elements; ++e) {
      const Complex deformation = shape(e + 1) - shape(e);
      mode.by_stiffness(e) = -deformation * deformation;
      norm += chain.damping[static_cast<std::size_t>(e)] * deformation * deformation;
    }
    for (Index k = 0; k < n; ++k) {
      const Complex square = shape(k + 1) * shape(k + 1);
      mode.by_mass(k) = -pole * pole * square;
      norm += 2.0 * pole * chain.masses[static_cast<std::size_t>(k)] * square;
    }
    mode.by_stiffness /= norm;
    mode.by_mass /= norm;
    modes.push_back(std::move(mode));
  }
  return modes;
}

}  // namespace dwell
