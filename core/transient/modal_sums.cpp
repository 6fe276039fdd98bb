#include "core/transient/modal_sums.hpp"

namespace dwell {

using Eigen::Index;

ModalSums::ModalSums(Index most) : normal_(most, most), pending_(most, kTogether), moments_(most) {}

void ModalSums::clear() noexcept {
  normal_.setZero();
  moments_.setZero();
  squares_ = samples_ = 0.0;
  pending_count_ = 0;
  referenced_ = false;
}

void ModalSums::add(const Eigen::VectorXd& x, Index all, double value) noexcept {
  if (!referenced_) {
    reference_ = value;
    referenced_ = true;
  }
  const double s = value - reference_;
  moments_.head(all) += s * x.head(all);
  squares_ += s * s;
  samples_ += 1.0;
  // The products of several samples at once: it is the going through the matrix that costs.
  pending_.col(pending_count_).head(all) = x.head(all);
  if (++pending_count_ == kTogether) add_pending(all);
}

void ModalSums::complete(Index all) noexcept {
  if (pending_count_ > 0) add_pending(all);
}

void ModalSums::add_pending(Index all) noexcept {
  static_assert(kTogether == 4);
  for (Index i = pending_count_; i < kTogether; ++i) pending_.col(i).setZero();
  const double *x0 = &pending_(0, 0), *x1 = &pending_(0, 1), *x2 = &pending_(0, 2), *x3 = &pending_(0, 3);
  for (Index j = 0; j < all; ++j) {
    double* column = &normal_(0, j);
    const double a = x0[j], b = x1[j], c = x2[j], d = x3[j];
    for (Index i = j; i < all; ++i) column[i] += (a * x0[i] + b * x1[i]) + (c * x2[i] + d * x3[i]);
  }
  pending_count_ = 0;
}

}  // namespace dwell
