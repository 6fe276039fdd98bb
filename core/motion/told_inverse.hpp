// The pseudo-inverse of an information matrix. Left out are unknowns that are not used, and directions that no reading
// determines, such as the common gauge of the biases: their eigenvalues are rounding.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dwell {

class ToldInverse {
 public:
  // H: symmetric, any scale of its unknowns. Allocates; thread-safe.
  ToldInverse(const Eigen::MatrixXd& H, const std::vector<bool>& used);

  // damping: Levenberg's, of H scaled to a unit diagonal.
  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& g, double damping) const;
  [[nodiscard]] Eigen::MatrixXd matrix() const;
  // Per unknown: part that lies in directions no reading tells of, 0 … 1.
  [[nodiscard]] const Eigen::VectorXd& undetermined() const noexcept { return undetermined_; }

 private:
  [[nodiscard]] Eigen::VectorXd inverted(double damping) const;

  Eigen::MatrixXd vectors_;
  Eigen::VectorXd values_;  // 0 where no reading tells
  Eigen::VectorXd undetermined_;
};

}  // namespace dwell
