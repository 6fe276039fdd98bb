#include "core/chain/mode_residual.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/base/rounding.hpp"
#include "core/chain/chain_state.hpp"
#include "core/chain/identify.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double kPoleStep = 1e-5;  // relative step of a pole for a central difference

// The matrix that multiplies (Re, Im) by z.
Matrix2d turn(std::complex<double> z) {
  Matrix2d by;
  by << z.real(), -z.imag(), z.imag(), z.real();
  return by;
}

}  // namespace

ModeResidual::ModeResidual(const Rig& rig, const ElementsResult& identified, double omega, const SeenMode& seen,
                           double pole_widens)
    : rig_(rig), identified_(identified), omega_(omega), seen_(seen) {
  const Index channels = identified.gain.cols();
  const int n = rig.mass_count();
  VectorXcd o = VectorXcd::Zero(channels);
  for (Index c = 0; c < channels; ++c)
    if (seen.fitted[static_cast<std::size_t>(c)])
      o(c) = as_observed(rig, static_cast<int>(c), seen.amplitude(c), seen.pole);
  x_ = identified.gain * o;
  const auto is_seen = [&](const Eigen::RowVectorXcd& by_channel) {
    for (Index c = 0; c < channels; ++c)
      if (!seen.fitted[static_cast<std::size_t>(c)] && std::abs(by_channel(c)) > kOnlyRounding * by_channel.norm())
        return false;
    return true;
  };
  const Complex inertia = -seen.pole * seen.pole;
  for (Index e = 0; e < static_cast<Index>(identified.elements.size()); ++e) {
    if (!identified.u[static_cast<std::size_t>(e)].allFinite()) continue;
    const int k = static_cast<int>(e) + 1;
    if (is_seen(force_row(rig, k, inertia).transpose() * identified.gain) &&
        is_seen(deformation_row(n, k).transpose() * identified.gain))
      elements_.push_back(e);
  }
  const auto E = static_cast<Index>(elements_.size());
  if (E == 0) return;
  deformation_.resize(E);
  scale_.resize(E);
  for (Index i = 0; i < E; ++i) {
    const int k = static_cast<int>(elements_[static_cast<std::size_t>(i)]) + 1;
    const Complex Z = identified.Z[static_cast<std::size_t>(k - 1)];
    deformation_(i) = deformation_row(n, k).cwiseProduct(x_).sum();
    scale_(i) = std::abs(force_row(rig, k, inertia).cwiseProduct(x_).sum()) + std::abs(Z * deformation_(i));
  }
  const MatrixXcd by = by_amplitude(seen.pole);
  scaled_residual_ = in_pairs(by * seen.amplitude);
  const Complex step = kPoleStep * seen.pole;
  by_pole_ = (by_amplitude(seen.pole + step) - by_amplitude(seen.pole - step)) * seen.amplitude / (2.0 * step);
  MatrixXd J(2 * E, 2 * channels + 2);
  for (Index i = 0; i < E; ++i) {
    for (Index c = 0; c < channels; ++c) J.block<2, 2>(2 * i, 2 * c) = turn(by(i, c) / scale_(i));
    J.block<2, 2>(2 * i, 2 * channels) = turn(by_pole_(i) / scale_(i));
  }
  near_ = J * seen.covariance * J.transpose() + covariance_of_effects();
  for (Index i = 0; i < E; ++i) near_.diagonal().segment<2>(2 * i).array() += second_order(i) / (scale_(i) * scale_(i));
  const auto by_pole = J.rightCols<2>();
  covariance_ = near_ + (pole_widens - 1) * by_pole * seen.pole_covariance() * by_pole.transpose();
  factor_.compute(covariance_);
  chi2_ = product(scaled_residual_, scaled_residual_);
}

MatrixXcd ModeResidual::by_amplitude(Complex pole) const {
  const int n = rig_.mass_count();
  const Index channels = identified_.gain.cols();
  MatrixXcd by(static_cast<Index>(elements_.size()), channels);
  for (Index i = 0; i < by.rows(); ++i) {
    const Index e = elements_[static_cast<std::size_t>(i)];
    const int k = static_cast<int>(e) + 1;
    const Complex Z = identified_.Z[static_cast<std::size_t>(e)];
    by.row(i) = (force_row(rig_, k, -pole * pole) - (stiffness(Z) + pole * damping(Z, omega_)) * deformation_row(n, k))
                    .transpose() *
                identified_.gain;
  }
  for (Index c = 0; c < channels; ++c) by.col(c) *= as_observed(rig_, static_cast<int>(c), 1.0, pole);
  return by;
}

MatrixXd ModeResidual::covariance_of_effects() const {
  const auto E = static_cast<Index>(elements_.size());
  MatrixXd covariance = MatrixXd::Zero(2 * E, 2 * E);
  const MatrixXcd by = by_amplitude(seen_.pole);
  for (const SourceEffect& effect : identified_.effects) {
    VectorXcd forces(E);
    for (Index i = 0; i < E; ++i) {
      const Index e = elements_[static_cast<std::size_t>(i)];
      forces(i) = -(effect.on_coefficients(2 * e) + seen_.pole * effect.on_coefficients(2 * e + 1)) * deformation_(i);
      forces(i) += by_pole_(i) * seen_.pole * effect.clock_u;
      if (effect.mass > e) forces(i) -= seen_.pole * seen_.pole * effect.mass_u * Y(effect.mass);
      for (const ReadingError& error : effect.readings)
        forces(i) +=
            by(i, error.channel) * seen_.amplitude(error.channel) * observed_too_small(rig_, error, seen_.pole);
    }
    const VectorXd v = in_pairs(forces);
    covariance.noalias() += v * v.transpose();
  }
  return covariance;
}

// E|δd|², m², of element elements()[i] by the errors of amplitudes and readings.
double ModeResidual::deformation_variance(Index i) const {
  const Index channels = identified_.gain.cols();
  const auto k = static_cast<int>(elements_[static_cast<std::size_t>(i)]) + 1;
  VectorXcd by_channel = (deformation_row(rig_.mass_count(), k).transpose() * identified_.gain).transpose();
  MatrixXd rows(2, 2 * channels);
  for (Index c = 0; c < channels; ++c) {
    by_channel(c) *= as_observed(rig_, static_cast<int>(c), 1.0, seen_.pole);
    rows.middleCols<2>(2 * c) = turn(by_channel(c));
  }
  double sum = (rows * seen_.covariance.topLeftCorner(2 * channels, 2 * channels) * rows.transpose()).trace();
  for (const SourceEffect& effect : identified_.effects) {
    Complex change{};
    for (const ReadingError& error : effect.readings)
      change +=
          by_channel(error.channel) * seen_.amplitude(error.channel) * observed_too_small(rig_, error, seen_.pole);
    sum += std::norm(change);
  }
  return sum;
}

// Second-order variance of R, N²: the product of the errors of Z and d, and the second-order error of Z = f/d. Factor
// 3: fully correlated normal errors have E[x⁴] = 3 E[x²]².
double ModeResidual::second_order(Index i) const {
  const auto e = static_cast<std::size_t>(elements_[static_cast<std::size_t>(i)]);
  const Eigen::Vector2d& u = identified_.u[e];
  const double Z2 = u(0) * u(0) + std::norm(seen_.pole) * u(1) * u(1);
  return 3 * Z2 * (deformation_variance(i) + Z2 / std::norm(identified_.Z[e]) * std::norm(deformation_(i)));
}

VectorXd ModeResidual::in_pairs(const VectorXcd& forces) const {
  VectorXd pairs(2 * forces.size());
  for (Index i = 0; i < forces.size(); ++i)
    pairs.segment<2>(2 * i) << forces(i).real() / scale_(i), forces(i).imag() / scale_(i);
  return pairs;
}

// χ² of 2m degrees of freedom exceeds x with probability exp(-x/2) Σ_{i<m} (x/2)^i / i!.
double ModeResidual::by_chance() const noexcept {
  double term = std::exp(-0.5 * chi2_), sum = 0.0;
  for (std::size_t i = 1; i <= elements_.size(); ++i) {
    sum += term;
    term *= 0.5 * chi2_ / static_cast<double>(i);
  }
  return elements_.empty() || !(chi2_ >= 0) ? 1.0 : sum;
}

double ModeResidual::pole_by_chance(const VectorXcd& shape) const {
  const int n = rig_.mass_count();
  if (static_cast<int>(elements_.size()) != rig_.element_count()) return 1.0;
  VectorXcd x = VectorXcd::Zero(n + 2);
  for (int k = 1; k <= n; ++k) x(k) = shape(k - 1) - (k > 1 ? shape(k - 2) : Complex{});
  MatrixXd work(2, scaled_residual_.size());
  for (Index i = 0; i < scale_.size(); ++i)
    work.middleCols<2>(2 * i) =
        turn(deformation_row(n, static_cast<int>(i) + 1).cwiseProduct(x).sum() * scale_(i) / scale_(0));
  const Eigen::Vector2d of_pole = work * scaled_residual_;
  const Matrix2d covariance = work * covariance_ * work.transpose();
  const double chi2 = of_pole.dot(covariance.ldlt().solve(of_pole));
  return chi2 >= 0 ? std::exp(-0.5 * chi2) : 1.0;
}

Index ModeResidual::worst(double* chi2) const noexcept {
  Index worst = 0;
  *chi2 = -1.0;
  for (Index i = 0; i < static_cast<Index>(elements_.size()); ++i) {
    const Eigen::Vector2d own = scaled_residual_.segment<2>(2 * i);
    const Matrix2d covariance = covariance_.block<2, 2>(2 * i, 2 * i);
    if (const double of = own.dot(covariance.llt().solve(own)); of > *chi2) *chi2 = of, worst = i;
  }
  return worst;
}

// Solves δc + λ δr = R/d: two real equations for two unknowns, since λ is not real.
Eigen::Vector2d ModeResidual::change(Index i) const noexcept {
  const Complex dZ = Complex{scaled_residual_(2 * i), scaled_residual_(2 * i + 1)} * scale_(i) / deformation_(i);
  const double r = dZ.imag() / seen_.pole.imag();
  return {dZ.real() - seen_.pole.real() * r, r};
}

Matrix2d ModeResidual::change_covariance(Index i) const noexcept {
  Matrix2d to_change;
  to_change << 1.0, -seen_.pole.real() / seen_.pole.imag(), 0.0, 1 / seen_.pole.imag();
  const Matrix2d by = to_change * turn(scale_(i) / deformation_(i));
  return by * near_.block<2, 2>(2 * i, 2 * i) * by.transpose();
}

VectorXcd ModeResidual::at_pole(const VectorXcd& dZ) const {
  VectorXcd forces(deformation_.size());
  for (Index i = 0; i < forces.size(); ++i) {
    const Complex of = dZ(elements_[static_cast<std::size_t>(i)]);
    forces(i) = (stiffness(of) + seen_.pole * damping(of, omega_)) * deformation_(i);
  }
  return forces;
}

Complex ModeResidual::Y(int place) const { return place == kGround ? Complex{} : Complex{x_.head(place + 1).sum()}; }

Complex ModeResidual::steady_Y(int place) const { return place == kGround ? Complex{} : identified_.Y(place); }

VectorXd ModeResidual::by_mass(Index mass) const {
  const double m = rig_.masses[static_cast<std::size_t>(mass)];
  const int place = static_cast<int>(mass) + 1;
  VectorXcd dZ = VectorXcd::Zero(identified_.d.size());
  for (Index e = 0; e <= mass; ++e) dZ(e) = omega_ * omega_ * m * identified_.Y(place) / identified_.d(e);
  VectorXcd forces = -at_pole(dZ);
  for (Index i = 0; i < forces.size(); ++i)
    if (elements_[static_cast<std::size_t>(i)] <= mass) forces(i) -= seen_.pole * seen_.pole * m * Y(place);
  return in_pairs(forces);
}

VectorXd ModeResidual::by_scale(Index channel) const {
  return in_pairs(by_amplitude(seen_.pole).col(channel) * seen_.amplitude(channel) -
                  at_pole(identified_.by_channel.col(channel)));
}

VectorXd ModeResidual::by_delay(Index channel) const {
  return in_pairs(-seen_.pole * by_amplitude(seen_.pole).col(channel) * seen_.amplitude(channel) +
                  at_pole(identified_.by_channel.col(channel) * Complex{0.0, omega_}));
}

// The connection bridges elements from+1 … to; one to the ground bridges elements 1 … from. These carry less then.
VectorXd ModeResidual::by_connection(int from, int to, bool damps) const {
  const bool grounded = to == kGround;
  const int first = grounded ? 1 : from + 1, last = grounded ? from : to;
  const Complex moves = grounded ? Y(from) : Y(to) - Y(from);
  const Complex steady = grounded ? steady_Y(from) : steady_Y(to) - steady_Y(from);
  VectorXcd dZ = VectorXcd::Zero(identified_.d.size());
  for (Index e = first - 1; e < last; ++e)
    dZ(e) = steady / identified_.d(e) * (damps ? Complex{0.0, omega_} : Complex{1.0});
  VectorXcd forces = -at_pole(dZ);
  for (Index i = 0; i < forces.size(); ++i)
    if (const Index e = elements_[static_cast<std::size_t>(i)]; e >= first - 1 && e < last)
      forces(i) += moves * (damps ? seen_.pole : Complex{1.0});
  return in_pairs(forces);
}

}  // namespace dwell
