#include "core/transient/linear_part.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace dwell {

using Eigen::Index;

LinearPart::LinearPart(int harmonics, Index most) {
  const ModalLayout largest{harmonics, most};
  work_.resize(largest.linear(), largest.linear());
  columns_.resize(largest.linear(), largest.slopes());
  slopes_.resize(largest.slopes(), largest.slopes());
  product_.resize(largest.linear());
}

Eigen::Block<Eigen::MatrixXd> LinearPart::weighed(const ModalLayout& layout, const ModalMotion& motion,
                                                  const ModalSums& sums, double prior, double line_prior) noexcept {
  const Index P = layout.linear();
  auto factor = work_.topLeftCorner(P, P);
  factor = sums.normal().topLeftCorner(P, P);
  for (Index i = layout.harmonic(); i < P; ++i)
    factor(i, i) += motion.decays(static_cast<std::size_t>((i - layout.harmonic()) / 2)) ? prior : line_prior;
  for (Index i = 0; i < layout.harmonic(); ++i) factor(i, i) *= 1 + 1e-13;
  return factor;
}

bool LinearPart::solve(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, double range,
                       double line_range, ModalSolution& of) noexcept {
  const Index P = layout.linear(), modal = layout.modal();
  of.usable = false;
  if (!(sums.samples() > static_cast<double>(P + 4))) return false;
  const double width2 = std::max(line_range * line_range, 1e-300);
  const double tighter = width2 / std::max(range * range, 1e-300);  // the line prior's variance over the other's
  double sigma2 = of.sigma2 > 0 ? std::min(of.sigma2, width2) : width2;
  // The prior's weight depends on the noise, and the noise on the fit: two passes are enough.
  for (int pass = 0; pass < 2; ++pass) {
    of.line_prior = std::max(sigma2 / width2, 1e-12 * sums.samples());
    of.prior = std::max(sigma2 / width2 * tighter, 1e-12 * sums.samples());
    auto factor = weighed(layout, motion, sums, of.prior, of.line_prior);
    Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
    if (llt.info() != Eigen::Success) return false;
    of.theta.head(P) = sums.moments().head(P);
    llt.solveInPlace(of.theta.head(P));
    // Squares of the residuals, without the prior's part.
    product_.head(P).noalias() = sums.normal().topLeftCorner(P, P).selfadjointView<Eigen::Lower>() * of.theta.head(P);
    const double squares = sums.squares() + of.theta.head(P).dot(product_.head(P) - 2 * sums.moments().head(P));
    sigma2 = std::max(squares, 1e-15 * sums.squares()) / (sums.samples() - static_cast<double>(P));
    if (pass == 1) {
      auto columns = columns_.topLeftCorner(P, modal);
      columns.setZero();
      for (Index i = 0; i < modal; ++i) columns(layout.harmonic() + i, i) = 1.0;
      llt.solveInPlace(columns);
      of.covariance.topLeftCorner(modal, modal) = sigma2 * columns.bottomRows(modal);
    }
  }
  of.sigma2 = sigma2;
  of.usable = of.theta.head(P).allFinite() && std::isfinite(sigma2);
  return of.usable;
}

bool LinearPart::eliminate(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, double prior,
                           double line_prior) noexcept {
  const Index P = layout.linear(), D = layout.slopes();
  auto factor = weighed(layout, motion, sums, prior, line_prior);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
  if (llt.info() != Eigen::Success) return false;
  auto columns = columns_.topLeftCorner(P, D);
  columns = sums.normal().block(P, 0, D, P).transpose();
  llt.matrixL().solveInPlace(columns);
  auto S = slopes_.topLeftCorner(D, D);
  S = sums.normal().block(P, P, D, D).selfadjointView<Eigen::Lower>();
  S.noalias() -= columns.transpose().lazyProduct(columns);
  return true;
}

// eliminate() left the factor of L'L in work_, and factor^-1 L'D in columns_.
Eigen::Block<const Eigen::MatrixXd> LinearPart::taken_over(const ModalLayout& layout) noexcept {
  const Index P = layout.linear();
  auto columns = columns_.topLeftCorner(P, layout.slopes());
  work_.topLeftCorner(P, P).triangularView<Eigen::Lower>().transpose().solveInPlace(columns);
  return std::as_const(columns_).topLeftCorner(P, layout.slopes());
}

}  // namespace dwell
