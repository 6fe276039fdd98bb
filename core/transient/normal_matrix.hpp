// Sums the normal matrix Σ x x' of a least squares fit over samples with regressors x. Regressors that are zero, such
// as those of faded modes, cost nothing.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace dwell {

class NormalMatrix {
 public:
  // most: capacity in regressors.
  explicit NormalMatrix(Eigen::Index most)
      : sum_(most, most), pending_(most, kTogether), runs_(static_cast<std::size_t>(most / 2 + 1)) {}

  void clear() noexcept;
  // Adds a sample by the first `all` elements of x; `all` stays the same until clear(). O(all²).
  void add(const Eigen::VectorXd& x, Eigen::Index all) noexcept;
  // Call before sum() is read.
  void complete(Eigen::Index all) noexcept;
  [[nodiscard]] const Eigen::MatrixXd& sum() const noexcept { return sum_; }  // lower triangle

  // Copies `other` as it was before its newest sample; `other` must not have been completed since.
  void take_all_but_newest(const NormalMatrix& other, Eigen::Index all) noexcept;

 private:
  static constexpr Eigen::Index kTogether = 4;
  struct Run {  // consecutive regressors [begin, end)
    Eigen::Index begin, end;
  };
  // Runs of regressors that are not zero in at least one pending sample.
  [[nodiscard]] std::span<const Run> runs_of_pending(Eigen::Index all) noexcept;

  Eigen::MatrixXd sum_;
  Eigen::MatrixXd pending_;  // of samples not yet in sum_; the newest stays here until complete()
  Eigen::Index pending_count_ = 0;
  std::vector<Run> runs_;
};

}  // namespace dwell
