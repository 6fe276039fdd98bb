// Σ x x' of the regressors x of a sequence of samples: the normal matrix of a least squares fit. Regressors that are
// zero, as those of modes that have decayed, cost nothing.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace dwell {

class NormalMatrix {
 public:
  // most: regressors at most.
  explicit NormalMatrix(Eigen::Index most)
      : sum_(most, most), pending_(most, kTogether), runs_(static_cast<std::size_t>(most / 2 + 1)) {}

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
  struct Run {  // of regressors, end excluded
    Eigen::Index begin, end;
  };
  // Those that are not zero in all pending samples.
  [[nodiscard]] std::span<const Run> runs_of_pending(Eigen::Index all) noexcept;

  Eigen::MatrixXd sum_;
  Eigen::MatrixXd pending_;  // regressors of the samples not yet in sum_; the newest is always here
  Eigen::Index pending_count_ = 0;
  std::vector<Run> runs_;
};

}  // namespace dwell
