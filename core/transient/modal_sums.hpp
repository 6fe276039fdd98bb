// What the modal fit needs to know of one channel's samples: the sums of the products of their regressors and readings.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>

namespace dwell {

class ModalSums {
 public:
  // most: regressors at most.
  explicit ModalSums(Eigen::Index most);

  void clear() noexcept;
  // A sample: its first `all` regressors, as many for each until clear(). O(all²).
  void add(const Eigen::VectorXd& x, Eigen::Index all, double value) noexcept;
  // To be called before the sums are read.
  void complete(Eigen::Index all) noexcept;

  [[nodiscard]] const Eigen::MatrixXd& normal() const noexcept { return normal_; }    // Σ x x', lower triangle
  [[nodiscard]] const Eigen::VectorXd& moments() const noexcept { return moments_; }  // Σ x s, s = value - reference
  [[nodiscard]] double squares() const noexcept { return squares_; }                  // Σ s²
  [[nodiscard]] double samples() const noexcept { return samples_; }
  // The first value: what readings are taken relative to, so that a large mean costs no digits.
  [[nodiscard]] double reference() const noexcept { return reference_; }

 private:
  static constexpr Eigen::Index kTogether = 4;
  void add_pending(Eigen::Index all) noexcept;

  Eigen::MatrixXd normal_;
  Eigen::MatrixXd pending_;  // regressors of the samples not yet in normal_
  Eigen::Index pending_count_ = 0;
  Eigen::VectorXd moments_;
  double squares_ = 0.0, samples_ = 0.0, reference_ = 0.0;
  bool referenced_ = false;
};

}  // namespace dwell
