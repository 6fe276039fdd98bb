#include "core/transient/pole_step.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr double kLeastDamping = 1e-5;  // damping ratio that a mode keeps at least: less looks like a steady line

}  // namespace

PoleStep::PoleStep(Index most)
    : gradient_(2 * most + 1),
      hessian_(2 * most + 1, 2 * most + 1),
      inverse_(2 * most + 2, 2 * most + 2),
      poles_(static_cast<std::size_t>(most)),
      u_poles_(static_cast<std::size_t>(most)),
      disagreement_(static_cast<std::size_t>(most)) {
  covariance_.setZero(2 * most + 1, 2 * most + 1);
}

void PoleStep::begin(const ModalLayout& layout) noexcept {
  const Index all = layout.modal() + 1;
  hessian_.topLeftCorner(all, all).setZero();
  gradient_.head(all).setZero();
  std::fill(disagreement_.begin(), disagreement_.end(), 0.0);
}

void PoleStep::add(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums,
                   const ModalSolution& solution, const Eigen::Block<const Eigen::MatrixXd>& S) noexcept {
  const Index P = layout.linear(), modal = layout.modal(), modes = layout.modes;
  auto H = hessian_.topLeftCorner(modal + 1, modal + 1);
  auto g = gradient_.head(modal + 1);
  const auto J = [&](Index m) { return solution.by_pole(layout, motion, m); };
  const auto score = [&](Index m) {
    Eigen::Vector2d sum = sums.moments().segment<2>(P + 2 * m);
    for (Index i = 0; i < P; ++i) sum -= solution.theta(i) * sums.normal().block<2, 1>(P + 2 * m, i);
    return sum;
  };
  for (Index m = 0; m < modes; ++m) {
    const Eigen::Vector2d own = J(m).transpose() * score(m) / solution.sigma2;
    g.segment<2>(2 * m) += own;
    note_disagreement(m, own, J(m).transpose() * S.block<2, 2>(2 * m, 2 * m) * J(m) / solution.sigma2);
    for (Index l = 0; l < modes; ++l)
      H.block<2, 2>(2 * m, 2 * l) += J(m).transpose() * S.block<2, 2>(2 * m, 2 * l) * J(l) / solution.sigma2;
  }
  const Eigen::Vector2d turned = solution.by_omega(layout);
  g(modal) += turned.dot(score(modes)) / solution.sigma2;
  for (Index m = 0; m < modes; ++m)
    H.block<2, 1>(2 * m, modal) += J(m).transpose() * S.block<2, 2>(2 * m, modal) * turned / solution.sigma2;
  H(modal, modal) += turned.dot(S.block<2, 2>(modal, modal) * turned) / solution.sigma2;
}

// At the common optimum, a channel's score is its information times the distance to its own optimum.
void PoleStep::note_disagreement(Index m, const Eigen::Vector2d& score, Eigen::Matrix2d information) noexcept {
  information.diagonal().array() += 1 / (ModalMotion::kOpen * ModalMotion::kOpen);
  double& most = disagreement_[static_cast<std::size_t>(m)];
  most = std::max(most, score.dot(information.inverse() * score));
}

void PoleStep::take(const ModalLayout& layout, const ModalMotion& motion, const FrequencyPrior& stated, double trust,
                    double trust_omega) noexcept {
  const Index modal = layout.modal();
  const double omega = motion.omega();
  auto H = hessian_.topLeftCorner(modal + 1, modal + 1);
  auto g = gradient_.head(modal + 1);
  H.row(modal).head(modal) = H.col(modal).head(modal).transpose();
  H(modal, modal) += 1 / std::max(trust_omega * trust_omega, ModalMotion::kGiven * ModalMotion::kGiven);
  // Derivatives by the relative change of ω: hence the factors ω.
  g(modal) += omega * stated.score(omega);
  H(modal, modal) += omega * omega * stated.information();
  invert_information(layout);
  H.diagonal().head(modal).array() += 1 / (trust * trust);
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(H);
  std::copy(motion.poles().begin(), motion.poles().end(), poles_.begin());
  omega_ = omega;
  length_ = 0.0;
  std::fill(u_poles_.begin(), u_poles_.end(), 0.0);
  if (llt.info() != Eigen::Success) return;
  llt.solveInPlace(g);
  auto unit = inverse_.topLeftCorner(modal + 1, modal + 1);
  unit.setIdentity();
  llt.solveInPlace(unit);
  for (std::size_t m = 0; m < motion.count(); ++m) {
    const auto i = 2 * static_cast<Index>(m);
    move(motion, m, {g(i), g(i + 1)}, {unit(i, i), unit(i + 1, i + 1)}, trust);
  }
  if (trust_omega > 0 && std::isfinite(g(modal))) {
    omega_ = omega * (1 + std::clamp(g(modal), -trust_omega, trust_omega));
    length_ = std::max(length_, std::abs(g(modal)) / std::sqrt(std::max(1e-300, unit(modal, modal))));
  }
}

// Moves pole m by the relative change rho, whose real and imaginary part have these variances.
void PoleStep::move(const ModalMotion& motion, std::size_t m, Complex rho, const Eigen::Vector2d& variances,
                    double trust) noexcept {
  const bool steady = !motion.decays(m);
  if (steady) rho.real(0.0);
  if (std::abs(rho) > 2 * trust) rho *= 2 * trust / std::abs(rho);
  const Complex pole = motion.poles()[m];
  const double size = std::abs(pole);
  Complex moved = pole + size * rho;
  // A mode keeps decaying and an oscillating pole keeps oscillating: each part keeps at least 0.3 of itself.
  moved.real(steady ? 0.0 : std::min({moved.real(), 0.3 * pole.real(), -kLeastDamping * size}));
  moved.imag(pole.imag() > 0 ? std::max(moved.imag(), 0.3 * pole.imag()) : 0.0);
  if (std::isfinite(moved.real()) && std::isfinite(moved.imag())) poles_[m] = moved;
  const double variance = std::max(1e-300, variances(1) + (steady ? 0.0 : variances(0)));
  u_poles_[m] = size * std::sqrt(steady ? variance : variance / 2);
  length_ = std::max(length_, std::abs(rho) / std::sqrt(variance));
}

// Covariance by the data, before the damping of the poles is added.
void PoleStep::invert_information(const ModalLayout& layout) noexcept {
  const Index modal = layout.modal(), all = modal + 1;
  auto factor = inverse_.topLeftCorner(all, all);
  factor = hessian_.topLeftCorner(all, all);
  factor.diagonal().head(modal).array() += 1 / (ModalMotion::kOpen * ModalMotion::kOpen);
  auto inverse = covariance_.topLeftCorner(all, all);
  inverse.setIdentity();
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
  if (llt.info() == Eigen::Success) llt.solveInPlace(inverse);
}

}  // namespace dwell
