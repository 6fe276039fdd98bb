#include "core/model/forward.hpp"

#include <Eigen/Eigenvalues>
#include <cassert>
#include <limits>
#include <utility>

#include "core/model/state_matrix.hpp"

namespace dwell {
namespace {

Phasor dynamic_stiffness(const Chain& chain, std::size_t element, Phasor s) {
  return chain.stiffness[element] + s * chain.damping[element];
}

}  // namespace

void solve_dynamic(const Chain& chain, Phasor s, std::vector<Phasor>& b) {
  const std::size_t n = chain.masses.size();
  assert(b.size() == n);
  if (n == 0) return;
  const auto elements = static_cast<std::size_t>(chain.element_count());
  std::vector<Phasor> lower(n), diagonal(n), upper(n), second(n);
  for (std::size_t k = 0; k < n; ++k) {
    diagonal[k] = s * s * chain.masses[k] + dynamic_stiffness(chain, k, s);
    if (k + 1 < elements) diagonal[k] += dynamic_stiffness(chain, k + 1, s);
    if (k + 1 < n) lower[k] = upper[k] = -dynamic_stiffness(chain, k + 1, s);
  }
  // Between resonances the matrix is indefinite. Without row exchanges a pivot could vanish.
  for (std::size_t k = 0; k + 1 < n; ++k) {
    if (std::norm(diagonal[k]) < std::norm(lower[k])) {
      std::swap(diagonal[k], lower[k]);
      std::swap(upper[k], diagonal[k + 1]);
      second[k] = std::exchange(upper[k + 1], Phasor{});
      std::swap(b[k], b[k + 1]);
    }
    const Phasor factor = lower[k] / diagonal[k];
    diagonal[k + 1] -= factor * upper[k];
    upper[k + 1] -= factor * second[k];
    b[k + 1] -= factor * b[k];
  }
  for (std::size_t k = n; k-- > 0;) {
    if (k + 1 < n) b[k] -= upper[k] * b[k + 1];
    if (k + 2 < n) b[k] -= second[k] * b[k + 2];
    b[k] /= diagonal[k];
  }
}

SteadyResponse steady_response(const Chain& chain, double omega, Phasor Y0) {
  const Phasor s(0.0, omega);
  std::vector<Phasor> b(chain.masses.size());
  if (!b.empty()) b[0] = dynamic_stiffness(chain, 0, s) * Y0;
  solve_dynamic(chain, s, b);
  SteadyResponse out;
  out.Y.reserve(b.size() + 1);
  out.Y.push_back(Y0);
  out.Y.insert(out.Y.end(), b.begin(), b.end());
  if (chain.boundary == Boundary::clamped) out.F = dynamic_stiffness(chain, chain.masses.size(), s) * out.Y.back();
  return out;
}

std::vector<std::complex<double>> natural_values(const Chain& chain) {
  if (chain.mass_count() == 0) return {};
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(state_matrix(chain).A, false);
  if (solver.info() != Eigen::Success) return {};
  const auto& values = solver.eigenvalues();
  return {values.data(), values.data() + values.size()};
}

double slowest_decay_rate(const Chain& chain) {
  if (chain.mass_count() == 0) return std::numeric_limits<double>::infinity();
  const auto values = natural_values(chain);
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  double rate = std::numeric_limits<double>::infinity();
  for (const auto& value : values) rate = std::min(rate, -value.real());
  return rate;
}

}  // namespace dwell
