#include "core/motion/told_inverse.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace dwell {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Of an information matrix scaled to a unit diagonal: eigenvalues below are rounding.
constexpr double kNull = 1e-11;

}  // namespace

ToldInverse::ToldInverse(const MatrixXd& H, const std::vector<bool>& used) {
  const Index size = H.rows();
  VectorXd scale(size);
  for (Index i = 0; i < size; ++i)
    scale(i) = used[static_cast<std::size_t>(i)] && H(i, i) > 0 ? 1 / std::sqrt(H(i, i)) : 0.0;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scale.asDiagonal() * H * scale.asDiagonal());
  vectors_ = scale.asDiagonal() * solver.eigenvectors();
  const double least = kNull * std::max(1.0, solver.eigenvalues().maxCoeff());
  values_ = VectorXd::Zero(size);
  undetermined_ = VectorXd::Zero(size);
  for (Index i = 0; i < size; ++i)
    if (solver.eigenvalues()(i) > least)
      values_(i) = solver.eigenvalues()(i);
    else
      undetermined_ += solver.eigenvectors().col(i).cwiseAbs2();
}

VectorXd ToldInverse::inverted(double damping) const {
  return values_.unaryExpr([damping](double v) { return v > 0 ? 1 / (v + damping) : 0.0; });
}

VectorXd ToldInverse::times(const VectorXd& g, double damping) const {
  return vectors_ * inverted(damping).cwiseProduct(vectors_.transpose() * g);
}

MatrixXd ToldInverse::matrix() const { return vectors_ * inverted(0.0).asDiagonal() * vectors_.transpose(); }

}  // namespace dwell
