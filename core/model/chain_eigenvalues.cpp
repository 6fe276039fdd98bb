#include "core/model/chain_eigenvalues.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dwell {

ChainEigenvalues::ChainEigenvalues(Boundary boundary, std::span<const double> masses)
    : boundary_(boundary),
      masses_(masses.begin(), masses.end()),
      solver_(static_cast<Eigen::Index>(2 * masses.size())) {
  const auto n = static_cast<Eigen::Index>(masses.size());
  A_.resize(2 * n, 2 * n);
  eigenvalues_.reserve(2 * masses_.size());
}

void ChainEigenvalues::update(std::span<const std::complex<double>> Z, double omega) noexcept {
  const auto n = static_cast<Eigen::Index>(masses_.size());
  eigenvalues_.clear();
  time_constant_s_ = n == 0 ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  if (n == 0) return;
  A_.setZero();
  A_.topRightCorner(n, n).diagonal().setConstant(omega);
  for (Eigen::Index k = 0; k < n; ++k) {
    // Mass k+1 lies between elements k+1 and k+2. The last mass of a free chain has no element k+2.
    for (const Eigen::Index e : {k, k + 1}) {
      if (e == n && boundary_ == Boundary::free) continue;
      const std::complex<double> z = Z[static_cast<std::size_t>(e)];
      if (!std::isfinite(z.real()) || !std::isfinite(z.imag())) return;
      const double m = masses_[static_cast<std::size_t>(k)], c = z.real() / (m * omega), r = z.imag() / (m * omega);
      const Eigen::Index other = e == k ? k - 1 : k + 1;
      A_(n + k, k) -= c;
      A_(n + k, n + k) -= r;
      if (other >= 0 && other < n) {
        A_(n + k, other) += c;
        A_(n + k, n + other) += r;
      }
    }
  }
  solver_.compute(A_, false);
  if (solver_.info() != Eigen::Success) return;
  for (const std::complex<double>& lambda : solver_.eigenvalues())
    if (lambda.imag() >= 0) eigenvalues_.push_back(lambda);
  std::sort(eigenvalues_.begin(), eigenvalues_.end(), [](const auto& a, const auto& b) { return a.real() > b.real(); });
  const double rate = -eigenvalues_.front().real();
  time_constant_s_ = rate > 0 ? 1 / rate : std::numeric_limits<double>::infinity();
}

}  // namespace dwell
