// The sums over a channel's samples that the modal fit needs: products of regressors x and readings. Views SharedSums.
#pragma once

#include <Eigen/Core>

namespace dwell {

// A channel's sums without the normal matrix, which channels may share. s = value - reference.
struct ReadingSums {
  Eigen::VectorXd moments;              // Σ x s
  double squares = 0.0, samples = 0.0;  // Σ s², number
  // The channel's first value; subtracting it keeps the digits where the mean is large.
  double reference = 0.0;
};

class ModalSums {
 public:
  // Both must outlive this.
  ModalSums(const Eigen::MatrixXd& normal, const ReadingSums& readings) noexcept
      : normal_(normal), readings_(readings) {}

  [[nodiscard]] const Eigen::MatrixXd& normal() const noexcept { return normal_; }  // Σ x x', lower triangle
  [[nodiscard]] const Eigen::VectorXd& moments() const noexcept { return readings_.moments; }  // Σ x s
  [[nodiscard]] double squares() const noexcept { return readings_.squares; }                  // Σ s²
  [[nodiscard]] double samples() const noexcept { return readings_.samples; }

 private:
  const Eigen::MatrixXd& normal_;
  const ReadingSums& readings_;
};

}  // namespace dwell
