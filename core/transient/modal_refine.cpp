// The poles and the frequency of the modal fit made better: variable projection, one step.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/complex.hpp"
#include "core/transient/modal_fit.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr double kKnown = 1e-12;        // relative, of a frequency that is given
constexpr double kOpen = 1.0;           // relative: a pole of which the data tell nothing
constexpr double kLeastDamping = 1e-5;  // of critical: what decays less is steady, as far as anyone sees

}  // namespace

// What the derivatives explain beyond the linear parameters: S = D'D - D'L (L'L)^-1 L'D into slopes_; the factor of L'L
// into work_, factor^-1 L'D into columns_.
bool ModalFit::eliminate_linear(const PerChannel& of, double prior, double line_prior) noexcept {
  const Index P = linear(), D = slopes();
  auto factor = work_.topLeftCorner(P, P);
  factor = of.normal.topLeftCorner(P, P);
  for (Index i = harmonic_; i < P; ++i)
    factor(i, i) += poles_[static_cast<std::size_t>((i - harmonic_) / 2)].real() < 0 ? prior : line_prior;
  for (Index i = 0; i < harmonic_; ++i) factor(i, i) *= 1 + 1e-13;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
  if (llt.info() != Eigen::Success) return false;
  auto columns = columns_.topLeftCorner(P, D);
  columns = of.normal.block(P, 0, D, P).transpose();
  llt.matrixL().solveInPlace(columns);
  auto S = slopes_.topLeftCorner(D, D);
  S = of.normal.block(P, P, D, D).selfadjointView<Eigen::Lower>();
  S.noalias() -= columns.transpose().lazyProduct(columns);
  return true;
}

std::span<const Complex> ModalFit::refined(double trust, double trust_omega) noexcept {
  const Index P = linear(), D = slopes();
  auto H = hessian_.topLeftCorner(modal_ + 1, modal_ + 1);
  auto g = gradient_.head(modal_ + 1);
  H.setZero();
  g.setZero();
  std::fill(disagreement_.begin(), disagreement_.end(), 0.0);
  for (PerChannel& channel : channels_) {
    if (!channel.usable || !(channel.sigma2 > 0)) continue;
    const double ridge = 1e-9 * channel.samples;
    if (!eliminate_linear(channel, ridge, ridge)) continue;
    const auto S = slopes_.topLeftCorner(D, D);
    const auto J = [&](Index m) { return slope_by_pole(channel, m); };
    const auto score = [&](Index m) {
      Eigen::Vector2d sum = channel.moments.segment<2>(P + 2 * m);
      for (Index i = 0; i < P; ++i) sum -= channel.theta(i) * channel.normal.block<2, 1>(P + 2 * m, i);
      return sum;
    };
    const Index modes = modal_ / 2;
    for (Index m = 0; m < modes; ++m) {
      const Eigen::Vector2d own = J(m).transpose() * score(m) / channel.sigma2;
      g.segment<2>(2 * m) += own;
      take_disagreement(m, own, J(m).transpose() * S.block<2, 2>(2 * m, 2 * m) * J(m) / channel.sigma2);
      for (Index l = 0; l < modes; ++l)
        H.block<2, 2>(2 * m, 2 * l) += J(m).transpose() * S.block<2, 2>(2 * m, 2 * l) * J(l) / channel.sigma2;
    }
    // p sin ωu + q cos ωu, by a relative change of ω: ωu (p cos ωu - q sin ωu).
    const Eigen::Vector2d turned{-channel.theta(harmonics_ + 1), channel.theta(1)};
    g(modal_) += turned.dot(score(modes)) / channel.sigma2;
    for (Index m = 0; m < modes; ++m)
      H.block<2, 1>(2 * m, modal_) += J(m).transpose() * S.block<2, 2>(2 * m, modal_) * turned / channel.sigma2;
    H(modal_, modal_) += turned.dot(S.block<2, 2>(modal_, modal_) * turned) / channel.sigma2;
  }
  H.row(modal_).head(modal_) = H.col(modal_).head(modal_).transpose();
  H(modal_, modal_) += 1 / std::max(trust_omega * trust_omega, kKnown * kKnown);
  // The derivative is by a relative change of ω.
  g(modal_) += omega_ * stated_.score(omega_);
  H(modal_, modal_) += omega_ * omega_ * stated_.information();
  invert_information();
  H.diagonal().head(modal_).array() += 1 / (trust * trust);
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(H);
  std::copy_n(poles_.begin(), count_, moved_.begin());
  moved_omega_ = omega_;
  converged_ = 0.0;
  std::fill(u_poles_.begin(), u_poles_.end(), 0.0);
  if (llt.info() != Eigen::Success) return {moved_.data(), count_};
  llt.solveInPlace(g);
  auto unit = slopes_.topLeftCorner(modal_ + 1, modal_ + 1);
  unit.setIdentity();
  llt.solveInPlace(unit);
  for (std::size_t m = 0; m < count_; ++m) {
    const auto i = 2 * static_cast<Index>(m);
    const bool steady = !(poles_[m].real() < 0);
    Complex rho{steady ? 0.0 : g(i), g(i + 1)};
    if (std::abs(rho) > 2 * trust) rho *= 2 * trust / std::abs(rho);
    const double size = std::abs(poles_[m]);
    Complex moved = poles_[m] + size * rho;
    // A transient decays, however slowly; a pole that oscillates goes on doing so.
    moved.real(steady ? 0.0 : std::min({moved.real(), 0.3 * poles_[m].real(), -kLeastDamping * size}));
    moved.imag(poles_[m].imag() > 0 ? std::max(moved.imag(), 0.3 * poles_[m].imag()) : 0.0);
    if (std::isfinite(moved.real()) && std::isfinite(moved.imag())) moved_[m] = moved;
    const double variance = std::max(1e-300, unit(i + 1, i + 1) + (steady ? 0.0 : unit(i, i)));
    u_poles_[m] = size * std::sqrt(steady ? variance : variance / 2);
    converged_ = std::max(converged_, std::abs(rho) / std::sqrt(variance));
  }
  if (trust_omega > 0 && std::isfinite(g(modal_))) {
    moved_omega_ = omega_ * (1 + std::clamp(g(modal_), -trust_omega, trust_omega));
    converged_ = std::max(converged_, std::abs(g(modal_)) / std::sqrt(std::max(1e-300, unit(modal_, modal_))));
  }
  return {moved_.data(), count_};
}

// At the common optimum the score of a channel is its information times the distance to its own optimum.
void ModalFit::take_disagreement(Index m, const Eigen::Vector2d& score, Eigen::Matrix2d information) noexcept {
  information.diagonal().array() += 1 / (kOpen * kOpen);
  double& most = disagreement_[static_cast<std::size_t>(m)];
  most = std::max(most, score.dot(information.inverse() * score));
}

ModalFit::Change ModalFit::last_change() const noexcept {
  Change change(modal_ + 1);
  for (std::size_t m = 0; m < count_; ++m) {
    const Complex by = (moved_[m] - poles_[m]) / sizes_[m];
    change.segment<2>(2 * static_cast<Index>(m)) << by.real(), by.imag();
  }
  change(modal_) = moved_omega_ / omega_ - 1;
  return change;
}

// b_m = a_m ρ_m, ρ the pole's relative change.
Eigen::Matrix2d ModalFit::slope_by_pole(const PerChannel& of, Index m) const noexcept {
  const Complex a{of.theta(harmonic_ + 2 * m), of.theta(harmonic_ + 2 * m + 1)};
  // Of a steady line the frequency alone is open.
  const double decays = poles_[static_cast<std::size_t>(m)].real() < 0 ? 1.0 : 0.0;
  Eigen::Matrix2d slope;
  slope << decays * a.real(), -a.imag(), decays * a.imag(), a.real();
  return slope;
}

// η: relative errors of the poles and of ω. L: the linear regressors. D: the regressors' derivatives, J their
// coefficients, so that η adds D J η to the model. Then η shifts the linear amplitudes by -(L'L)^-1 L'D J η.
void ModalFit::propagate_poles(bool omega_known) noexcept {
  const Index P = linear(), D = slopes(), all = modal_ + 1;
  auto H = hessian_.topLeftCorner(all, all);
  H.setZero();
  for (PerChannel& channel : channels_) {
    if (!channel.usable || !(channel.sigma2 > 0)) continue;
    if (!eliminate_linear(channel, channel.prior, channel.line_prior)) continue;
    const auto S = slopes_.topLeftCorner(D, D);
    auto columns = columns_.topLeftCorner(P, D);
    work_.topLeftCorner(P, P).triangularView<Eigen::Lower>().transpose().solveInPlace(columns);
    auto by_poles = channel.by_poles.topLeftCorner(2 * modal_, all);
    auto onto = by_poles.topRows(modal_), slope = by_poles.bottomRows(modal_);
    slope.setZero();
    // J has two entries in each column.
    const Eigen::Vector2d turned{-channel.theta(harmonics_ + 1), channel.theta(1)};
    const auto apply = [&](Index m, const auto& J, auto&& of, auto&& to) {
      to.noalias() = of.template middleCols<2>(2 * m).lazyProduct(J);
    };
    auto SJ = products_.topLeftCorner(D, all);
    for (Index m = 0; m < modal_ / 2; ++m) {
      // A mode that shows in no channel is taken as absent, whatever its pole.
      if (!shows(static_cast<std::size_t>(m))) {
        onto.middleCols<2>(2 * m).setZero();
        SJ.middleCols<2>(2 * m).setZero();
        continue;
      }
      const Eigen::Matrix2d J = slope_by_pole(channel, m);
      slope.block<2, 2>(2 * m, 2 * m) = J;
      apply(m, J, columns.bottomRows(modal_), onto.middleCols<2>(2 * m));
      apply(m, J, S, SJ.middleCols<2>(2 * m));
    }
    apply(modal_ / 2, turned, columns.bottomRows(modal_), onto.col(modal_));
    apply(modal_ / 2, turned, S, SJ.col(modal_));
    onto *= -1;
    for (Index m = 0; m < modal_ / 2; ++m)
      H.middleRows<2>(2 * m) +=
          slope.block<2, 2>(2 * m, 2 * m).transpose().lazyProduct(SJ.middleRows<2>(2 * m)) / channel.sigma2;
    H.row(modal_) += turned.transpose().lazyProduct(SJ.bottomRows<2>()) / channel.sigma2;
    channel.propagated = true;
  }
  const double seen_s = std::max(1e-9, 1e-9 * static_cast<double>(newest_ns_ - t0_ns_));
  for (Index i = 0; i < modal_; ++i) {
    const auto m = static_cast<std::size_t>(i / 2);
    const double width = std::max(1 / seen_s, -poles_[m].real()) / sizes_[m];
    H(i, i) += 1 / (width * width);
  }
  H(modal_, modal_) +=
      omega_ * omega_ * stated_.information() + (omega_known ? 1 / (kKnown * kKnown) : 1 / (kOpen * kOpen));
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(H);
  auto covariance = propagated_.topLeftCorner(all, all);
  covariance.setIdentity();
  const bool solved = llt.info() == Eigen::Success;
  if (solved) llt.solveInPlace(covariance);
  for (PerChannel& channel : channels_) {
    channel.propagated = channel.propagated && solved;
    if (!channel.propagated) continue;
    const auto by_poles = channel.by_poles.topLeftCorner(2 * modal_, all);
    auto product = products_.topLeftCorner(2 * modal_, all);
    product.noalias() = by_poles.lazyProduct(covariance);
    auto whole = channel.whole.topLeftCorner(2 * modal_, 2 * modal_);
    whole.noalias() = product.lazyProduct(by_poles.transpose());
    whole.topLeftCorner(modal_, modal_) += channel.covariance.topLeftCorner(modal_, modal_);
  }
}

// What the data alone tell of the poles, from hessian_ before any trust is added.
void ModalFit::invert_information() noexcept {
  const Index all = modal_ + 1;
  auto factor = slopes_.topLeftCorner(all, all);
  factor = hessian_.topLeftCorner(all, all);
  factor.diagonal().head(modal_).array() += 1 / (kOpen * kOpen);
  auto inverse = relative_covariance_.topLeftCorner(all, all);
  inverse.setIdentity();
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
  if (llt.info() == Eigen::Success) llt.solveInPlace(inverse);
}

Eigen::Matrix2d ModalFit::pole_covariance(std::size_t m) const noexcept {
  const auto i = 2 * static_cast<Index>(m);
  return sizes_[m] * sizes_[m] * relative_covariance_.block<2, 2>(i, i);
}

}  // namespace dwell
