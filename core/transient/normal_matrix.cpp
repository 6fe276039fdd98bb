#include "core/transient/normal_matrix.hpp"

#include <cassert>

namespace dwell {

using Eigen::Index;

void NormalMatrix::clear() noexcept {
  sum_.setZero();
  pending_count_ = 0;
}

void NormalMatrix::add(const Eigen::VectorXd& x, Index all) noexcept {
  if (pending_count_ == kTogether) complete(all);
  pending_.col(pending_count_++).head(all) = x.head(all);
}

// The products of several samples at once: it is the going through the matrix that costs.
void NormalMatrix::complete(Index all) noexcept {
  static_assert(kTogether == 4);
  if (pending_count_ == 0) return;
  for (Index i = pending_count_; i < kTogether; ++i) pending_.col(i).head(all).setZero();
  const double *x0 = &pending_(0, 0), *x1 = &pending_(0, 1), *x2 = &pending_(0, 2), *x3 = &pending_(0, 3);
  for (Index j = 0; j < all; ++j) {
    double* column = &sum_(0, j);
    const double a = x0[j], b = x1[j], c = x2[j], d = x3[j];
    for (Index i = j; i < all; ++i) column[i] += (a * x0[i] + b * x1[i]) + (c * x2[i] + d * x3[i]);
  }
  pending_count_ = 0;
}

void NormalMatrix::take_all_but_newest(const NormalMatrix& other, Index all) noexcept {
  assert(other.pending_count_ > 0);
  sum_.topLeftCorner(all, all) = other.sum_.topLeftCorner(all, all);
  pending_count_ = other.pending_count_ - 1;
  pending_.topLeftCorner(all, pending_count_) = other.pending_.topLeftCorner(all, pending_count_);
}

}  // namespace dwell
