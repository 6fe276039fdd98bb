#include "core/chain/provisional_chain.hpp"

#include <algorithm>
#include <cmath>

#include "core/chain/estimate.hpp"
#include "core/chain/identify.hpp"

namespace dwell {
namespace {

constexpr double kSoftest = 0.05, kLeastLoss = 0.005;  // smallest Re Z and Im Z assumed, relative to |Z|
constexpr double kOfEigenvalues = 10.0;  // multiplications per cube of the order (Golub and Van Loan, 7.5.6)

}  // namespace

ProvisionalChain::ProvisionalChain(const Rig& rig, const Eigen::MatrixXd& G, Slices* slices)
    : rig_(rig), slices_(slices), observation_(rig, G), eigenvalues_(rig.boundary, rig.masses), x_(G.cols()) {
  const auto unknowns = static_cast<std::size_t>(rig.mass_count());
  Y_.resize(unknowns + 1);
  d_.resize(unknowns);
  Z_.resize(static_cast<std::size_t>(rig.element_count()));
}

void ProvisionalChain::observe(int c, Complex X, double omega) noexcept {
  observation_.observe(c, as_observed(rig_, c, X, omega, 1));
}

bool ProvisionalChain::solve(double omega) noexcept {
  if (!observation_.solve(x_)) return false;
  identify_chain(omega);
  return true;
}

std::span<const Complex> ProvisionalChain::seen_by(const ModalFit& fit) noexcept {
  for (int c = 0; c < static_cast<int>(rig_.channels.size()); ++c)
    if (fit.usable(c))
      observe(c, fit.phasor(c, 1), fit.omega());
    else
      leave_out(c);
  if (!solve(fit.omega())) return {};
  return eigenvalues_.values();
}

// Identifies the elements from the state x_, then the time constant and the poles.
void ProvisionalChain::identify_chain(double omega) noexcept {
  const int n = rig_.mass_count();
  Y_[0] = x_(0);
  for (int k = 1; k <= n; ++k) {
    d_[static_cast<std::size_t>(k - 1)] = x_(k);
    Y_[static_cast<std::size_t>(k)] = Y_[static_cast<std::size_t>(k - 1)] + x_(k);
  }
  identify(rig_.boundary, rig_.masses, omega, Y_, d_, x_(n + 1), Z_);
  time_constant_s_ = solve_decay(omega);
  // A real chain is passive. If noise or a transient make this one look active, a lightly damped one gives the poles.
  bool passive = true;
  for (Complex& z : Z_) {
    const Complex nearest{std::max(z.real(), kSoftest * std::abs(z)), std::max(z.imag(), kLeastLoss * std::abs(z))};
    passive = passive && nearest == z;
    z = nearest;
  }
  if (!passive) static_cast<void>(solve_decay(omega));
}

double ProvisionalChain::solve_decay(double omega) noexcept {
  eigenvalues_.update(Z_, omega);
  if (slices_ != nullptr) slices_->spend(kOfEigenvalues * std::pow(2.0 * rig_.mass_count(), 3));
  return eigenvalues_.time_constant_s();
}

}  // namespace dwell
