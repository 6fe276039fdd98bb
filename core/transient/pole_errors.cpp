#include "core/transient/pole_errors.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace dwell {

using Eigen::Index;

PoleErrors::PoleErrors(Index most)
    : information_(2 * most + 1, 2 * most + 1),
      covariance_(2 * most + 1, 2 * most + 1),
      products_(4 * most + 2, 2 * most + 1) {}

void PoleErrors::begin(const ModalLayout& layout) noexcept {
  information_.topLeftCorner(layout.modal() + 1, layout.modal() + 1).setZero();
}

void PoleErrors::add(const ModalLayout& layout, const ModalMotion& motion, const ModalSolution& solution,
                     LinearPart& linear, std::span<const bool> shows, Effect& effect) noexcept {
  const Index modal = layout.modal(), all = modal + 1;
  auto H = information_.topLeftCorner(all, all);
  const auto S = linear.beyond(layout);
  const auto columns = linear.taken_over(layout);
  auto by_poles = effect.by_poles.topLeftCorner(2 * modal, all);
  auto onto = by_poles.topRows(modal), slope = by_poles.bottomRows(modal);
  slope.setZero();
  // J is block diagonal: a block for each mode, and one for ω.
  const Eigen::Vector2d turned = solution.by_omega(layout);
  const auto apply = [&](Index m, const auto& J, auto&& of, auto&& to) {
    to.noalias() = of.template middleCols<2>(2 * m).lazyProduct(J);
  };
  auto SJ = products_.topLeftCorner(layout.slopes(), all);
  for (Index m = 0; m < layout.modes; ++m) {
    // A mode that shows in no channel counts as absent, whatever its pole.
    if (!shows[static_cast<std::size_t>(m)]) {
      onto.middleCols<2>(2 * m).setZero();
      SJ.middleCols<2>(2 * m).setZero();
      continue;
    }
    const Eigen::Matrix2d J = solution.by_pole(layout, motion, m);
    slope.block<2, 2>(2 * m, 2 * m) = J;
    apply(m, J, columns.bottomRows(modal), onto.middleCols<2>(2 * m));
    apply(m, J, S, SJ.middleCols<2>(2 * m));
  }
  apply(layout.modes, turned, columns.bottomRows(modal), onto.col(modal));
  apply(layout.modes, turned, S, SJ.col(modal));
  onto *= -1;
  for (Index m = 0; m < layout.modes; ++m)
    H.middleRows<2>(2 * m) +=
        slope.block<2, 2>(2 * m, 2 * m).transpose().lazyProduct(SJ.middleRows<2>(2 * m)) / solution.sigma2;
  H.row(modal) += turned.transpose().lazyProduct(SJ.bottomRows<2>()) / solution.sigma2;
}

bool PoleErrors::solve(const ModalLayout& layout, const ModalMotion& motion, double seen_s,
                       double omega_information) noexcept {
  const Index modal = layout.modal(), all = modal + 1;
  auto H = information_.topLeftCorner(all, all);
  for (Index i = 0; i < modal; ++i) {
    const auto m = static_cast<std::size_t>(i / 2);
    const double width = std::max(1 / seen_s, -motion.poles()[m].real()) / motion.size(m);
    H(i, i) += 1 / (width * width);
  }
  H(modal, modal) += omega_information;
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(H);
  auto covariance = covariance_.topLeftCorner(all, all);
  covariance.setIdentity();
  if (llt.info() != Eigen::Success) return false;
  llt.solveInPlace(covariance);
  return true;
}

void PoleErrors::propagate(const ModalLayout& layout, const ModalSolution& solution, Effect& effect) noexcept {
  const Index modal = layout.modal(), all = modal + 1;
  const auto by_poles = effect.by_poles.topLeftCorner(2 * modal, all);
  auto product = products_.topLeftCorner(2 * modal, all);
  product.noalias() = by_poles.lazyProduct(covariance_.topLeftCorner(all, all));
  auto whole = effect.whole.topLeftCorner(2 * modal, 2 * modal);
  whole.noalias() = product.lazyProduct(by_poles.transpose());
  whole.topLeftCorner(modal, modal) += solution.covariance.topLeftCorner(modal, modal);
}

}  // namespace dwell
