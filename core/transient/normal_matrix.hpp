// Σ x x' of the regressors x of a sequence of samples: the normal matrix of a least squares fit.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>

namespace dwell {

class NormalMatrix {
 public:
  // most: regressors at most.
  explicit NormalMatrix(Eigen::Index most) : sum_(most, most), pending_(most, kTogether) {}

  void clear() noexcept;
  // A sample: its first `all` regressors, as many for each until clear(). O(all²).
  void add(const Eigen::VectorXd& x, Eigen::Index all) noexcept;
  // To be called before the sum is read.
  void complete(Eigen::Index all) noexcept;
  [[nodiscard]] const Eigen::MatrixXd& sum() const noexcept { return sum_; }  // lower triangle

  // Becomes what `other` was before its newest sample. No complete() since that.
  void take_all_but_newest(const NormalMatrix& other, Eigen::Index all) noexcept;

 private:
  static constexpr Eigen::Index kTogether = 4;

  Eigen::MatrixXd sum_;
  Eigen::MatrixXd pending_;  // regressors of the samples not yet in sum_; the newest is always here
  Eigen::Index pending_count_ = 0;
};

}  // namespace dwell
