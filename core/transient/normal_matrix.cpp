#include "core/transient/normal_matrix.hpp"

#include <algorithm>
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

// Adds four samples in one pass: the pass over the matrix is what costs.
void NormalMatrix::complete(Index all) noexcept {
  static_assert(kTogether == 4);
  if (pending_count_ == 0) return;
  for (Index i = pending_count_; i < kTogether; ++i) pending_.col(i).head(all).setZero();
  const double *x0 = &pending_(0, 0), *x1 = &pending_(0, 1), *x2 = &pending_(0, 2), *x3 = &pending_(0, 3);
  const std::span<const Run> runs = runs_of_pending(all);
  for (std::size_t k = 0; k < runs.size(); ++k)
    for (Index j = runs[k].begin; j < runs[k].end; ++j) {
      double* column = &sum_(0, j);
      const double a = x0[j], b = x1[j], c = x2[j], d = x3[j];
      Index i = j;
      for (const Run& run : runs.subspan(k)) {
        for (i = std::max(i, run.begin); i < run.end; ++i)
          column[i] += (a * x0[i] + b * x1[i]) + (c * x2[i] + d * x3[i]);
      }
    }
  pending_count_ = 0;
}

std::span<const NormalMatrix::Run> NormalMatrix::runs_of_pending(Index all) noexcept {
  std::size_t count = 0;
  bool in_run = false;
  for (Index i = 0; i < all; ++i) {
    const bool zero = pending_(i, 0) == 0 && pending_(i, 1) == 0 && pending_(i, 2) == 0 && pending_(i, 3) == 0;
    if (!zero && !in_run) runs_[count++].begin = i;
    if (!zero) runs_[count - 1].end = i + 1;
    in_run = !zero;
  }
  return {runs_.data(), count};
}

void NormalMatrix::take_all_but_newest(const NormalMatrix& other, Index all) noexcept {
  assert(other.pending_count_ > 0);
  sum_.topLeftCorner(all, all) = other.sum_.topLeftCorner(all, all);
  pending_count_ = other.pending_count_ - 1;
  pending_.topLeftCorner(all, pending_count_) = other.pending_.topLeftCorner(all, pending_count_);
}

}  // namespace dwell
