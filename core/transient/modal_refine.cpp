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
  for (Index i = steady(); i < P; ++i)
    factor(i, i) += poles()[static_cast<std::size_t>((i - steady()) / 2)].real() < 0 ? prior : line_prior;
  for (Index i = 0; i < steady(); ++i) factor(i, i) *= 1 + 1e-13;
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
  auto H = hessian_.topLeftCorner(modal() + 1, modal() + 1);
  auto g = gradient_.head(modal() + 1);
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
    const Index modes = modal() / 2;
    for (Index m = 0; m < modes; ++m) {
      const Eigen::Vector2d own = J(m).transpose() * score(m) / channel.sigma2;
      g.segment<2>(2 * m) += own;
      take_disagreement(m, own, J(m).transpose() * S.block<2, 2>(2 * m, 2 * m) * J(m) / channel.sigma2);
      for (Index l = 0; l < modes; ++l)
        H.block<2, 2>(2 * m, 2 * l) += J(m).transpose() * S.block<2, 2>(2 * m, 2 * l) * J(l) / channel.sigma2;
    }
    // p sin ωu + q cos ωu, by a relative change of ω: ωu (p cos ωu - q sin ωu).
    const Eigen::Vector2d turned{-channel.theta(regressors_.harmonics() + 1), channel.theta(1)};
    g(modal()) += turned.dot(score(modes)) / channel.sigma2;
    for (Index m = 0; m < modes; ++m)
      H.block<2, 1>(2 * m, modal()) += J(m).transpose() * S.block<2, 2>(2 * m, modal()) * turned / channel.sigma2;
    H(modal(), modal()) += turned.dot(S.block<2, 2>(modal(), modal()) * turned) / channel.sigma2;
  }
  H.row(modal()).head(modal()) = H.col(modal()).head(modal()).transpose();
  H(modal(), modal()) += 1 / std::max(trust_omega * trust_omega, kKnown * kKnown);
  // The derivative is by a relative change of ω.
  g(modal()) += omega() * stated_.score(omega());
  H(modal(), modal()) += omega() * omega() * stated_.information();
  invert_information();
  H.diagonal().head(modal()).array() += 1 / (trust * trust);
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(H);
  std::copy_n(poles().begin(), poles().size(), moved_.begin());
  moved_omega_ = omega();
  converged_ = 0.0;
  std::fill(u_poles_.begin(), u_poles_.end(), 0.0);
  if (llt.info() != Eigen::Success) return {moved_.data(), poles().size()};
  llt.solveInPlace(g);
  auto unit = slopes_.topLeftCorner(modal() + 1, modal() + 1);
  unit.setIdentity();
  llt.solveInPlace(unit);
  for (std::size_t m = 0; m < poles().size(); ++m) {
    const auto i = 2 * static_cast<Index>(m);
    const bool steady = !(poles()[m].real() < 0);
    Complex rho{steady ? 0.0 : g(i), g(i + 1)};
    if (std::abs(rho) > 2 * trust) rho *= 2 * trust / std::abs(rho);
    const double size = std::abs(poles()[m]);
    Complex moved = poles()[m] + size * rho;
    // A transient decays, however slowly; a pole that oscillates goes on doing so.
    moved.real(steady ? 0.0 : std::min({moved.real(), 0.3 * poles()[m].real(), -kLeastDamping * size}));
    moved.imag(poles()[m].imag() > 0 ? std::max(moved.imag(), 0.3 * poles()[m].imag()) : 0.0);
    if (std::isfinite(moved.real()) && std::isfinite(moved.imag())) moved_[m] = moved;
    const double variance = std::max(1e-300, unit(i + 1, i + 1) + (steady ? 0.0 : unit(i, i)));
    u_poles_[m] = size * std::sqrt(steady ? variance : variance / 2);
    converged_ = std::max(converged_, std::abs(rho) / std::sqrt(variance));
  }
  if (trust_omega > 0 && std::isfinite(g(modal()))) {
    moved_omega_ = omega() * (1 + std::clamp(g(modal()), -trust_omega, trust_omega));
    converged_ = std::max(converged_, std::abs(g(modal())) / std::sqrt(std::max(1e-300, unit(modal(), modal()))));
  }
  return {moved_.data(), poles().size()};
}

// At the common optimum the score of a channel is its information times the distance to its own optimum.
void ModalFit::take_disagreement(Index m, const Eigen::Vector2d& score, Eigen::Matrix2d information) noexcept {
  information.diagonal().array() += 1 / (kOpen * kOpen);
  double& most = disagreement_[static_cast<std::size_t>(m)];
  most = std::max(most, score.dot(information.inverse() * score));
}

ModalFit::Change ModalFit::last_change() const noexcept {
  Change change(modal() + 1);
  for (std::size_t m = 0; m < poles().size(); ++m) {
    const Complex by = (moved_[m] - poles()[m]) / regressors_.sizes()[m];
    change.segment<2>(2 * static_cast<Index>(m)) << by.real(), by.imag();
  }
  change(modal()) = moved_omega_ / omega() - 1;
  return change;
}

// b_m = a_m ρ_m, ρ the pole's relative change.
Eigen::Matrix2d ModalFit::slope_by_pole(const PerChannel& of, Index m) const noexcept {
  const Complex a{of.theta(steady() + 2 * m), of.theta(steady() + 2 * m + 1)};
  // Of a steady line the frequency alone is open.
  const double decays = poles()[static_cast<std::size_t>(m)].real() < 0 ? 1.0 : 0.0;
  Eigen::Matrix2d slope;
  slope << decays * a.real(), -a.imag(), decays * a.imag(), a.real();
  return slope;
}

// η: relative errors of the poles and of ω. L: the linear regressors. D: the regressors' derivatives, J their
// coefficients, so that η adds D J η to the model. Then η shifts the linear amplitudes by -(L'L)^-1 L'D J η.
void ModalFit::propagate_poles(bool omega_known) noexcept {
  const Index P = linear(), D = slopes(), all = modal() + 1;
  auto H = hessian_.topLeftCorner(all, all);
  H.setZero();
  for (PerChannel& channel : channels_) {
    if (!channel.usable || !(channel.sigma2 > 0)) continue;
    if (!eliminate_linear(channel, channel.prior, channel.line_prior)) continue;
    const auto S = slopes_.topLeftCorner(D, D);
    auto columns = columns_.topLeftCorner(P, D);
    work_.topLeftCorner(P, P).triangularView<Eigen::Lower>().transpose().solveInPlace(columns);
    auto by_poles = channel.by_poles.topLeftCorner(2 * modal(), all);
    auto onto = by_poles.topRows(modal()), slope = by_poles.bottomRows(modal());
    slope.setZero();
    // J has two entries in each column.
    const Eigen::Vector2d turned{-channel.theta(regressors_.harmonics() + 1), channel.theta(1)};
    const auto apply = [&](Index m, const auto& J, auto&& of, auto&& to) {
      to.noalias() = of.template middleCols<2>(2 * m).lazyProduct(J);
    };
    auto SJ = products_.topLeftCorner(D, all);
    for (Index m = 0; m < modal() / 2; ++m) {
      // A mode that shows in no channel is taken as absent, whatever its pole.
      if (!shows(static_cast<std::size_t>(m))) {
        onto.middleCols<2>(2 * m).setZero();
        SJ.middleCols<2>(2 * m).setZero();
        continue;
      }
      const Eigen::Matrix2d J = slope_by_pole(channel, m);
      slope.block<2, 2>(2 * m, 2 * m) = J;
      apply(m, J, columns.bottomRows(modal()), onto.middleCols<2>(2 * m));
      apply(m, J, S, SJ.middleCols<2>(2 * m));
    }
    apply(modal() / 2, turned, columns.bottomRows(modal()), onto.col(modal()));
    apply(modal() / 2, turned, S, SJ.col(modal()));
    onto *= -1;
    for (Index m = 0; m < modal() / 2; ++m)
      H.middleRows<2>(2 * m) +=
          slope.block<2, 2>(2 * m, 2 * m).transpose().lazyProduct(SJ.middleRows<2>(2 * m)) / channel.sigma2;
    H.row(modal()) += turned.transpose().lazyProduct(SJ.bottomRows<2>()) / channel.sigma2;
    channel.propagated = true;
  }
  const double seen_s = std::max(1e-9, 1e-9 * static_cast<double>(newest_ns_ - t0_ns()));
  for (Index i = 0; i < modal(); ++i) {
    const auto m = static_cast<std::size_t>(i / 2);
    const double width = std::max(1 / seen_s, -poles()[m].real()) / regressors_.sizes()[m];
    H(i, i) += 1 / (width * width);
  }
  H(modal(), modal()) +=
      omega() * omega() * stated_.information() + (omega_known ? 1 / (kKnown * kKnown) : 1 / (kOpen * kOpen));
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(H);
  auto covariance = propagated_.topLeftCorner(all, all);
  covariance.setIdentity();
  const bool solved = llt.info() == Eigen::Success;
  if (solved) llt.solveInPlace(covariance);
  for (PerChannel& channel : channels_) {
    channel.propagated = channel.propagated && solved;
    if (!channel.propagated) continue;
    const auto by_poles = channel.by_poles.topLeftCorner(2 * modal(), all);
    auto product = products_.topLeftCorner(2 * modal(), all);
    product.noalias() = by_poles.lazyProduct(covariance);
    auto whole = channel.whole.topLeftCorner(2 * modal(), 2 * modal());
    whole.noalias() = product.lazyProduct(by_poles.transpose());
    whole.topLeftCorner(modal(), modal()) += channel.covariance.topLeftCorner(modal(), modal());
  }
}

// What the data alone tell of the poles, from hessian_ before any trust is added.
void ModalFit::invert_information() noexcept {
  const Index all = modal() + 1;
  auto factor = slopes_.topLeftCorner(all, all);
  factor = hessian_.topLeftCorner(all, all);
  factor.diagonal().head(modal()).array() += 1 / (kOpen * kOpen);
  auto inverse = relative_covariance_.topLeftCorner(all, all);
  inverse.setIdentity();
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
  if (llt.info() == Eigen::Success) llt.solveInPlace(inverse);
}

Eigen::Matrix2d ModalFit::pole_covariance(std::size_t m) const noexcept {
  const auto i = 2 * static_cast<Index>(m);
  return regressors_.sizes()[m] * regressors_.sizes()[m] * relative_covariance_.block<2, 2>(i, i);
}

}  // namespace dwell
