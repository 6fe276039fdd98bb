// Computes the second-order effect of all error sources of a dwell on one element.
//
// An element's dynamic stiffness is Z = f/d. Errors t_i ~ N(0, 1), one for each source, change Z by
//
//   δZ = Σ_i A_i t_i + Σ_ij q_ij t_i t_j ,   q_ij = -(A_i B_j + A_j B_i)/2 + (i = j: D_i)
//
// with A_i = ∂Z/∂t_i and B_i = (∂d/∂t_i)/d. D_i is the change of Z by -φ²/2 of the phasors that error i turns by φ. The
// first sum is the law of propagation (core/chain/propagation.hpp). This class gives the mean products of the second
// sum. With p and q each its real or imaginary part,
//
//   E[p q] = 2 Σ_ij q_ij,p q_ij,q + (Σ_i q_ii,p)(Σ_i q_ii,q) .
//
// Products of first and third order are left out. Source: GUM, JCGM 100, 5.1.2, note; docs/method.md, Uncertainty.
#pragma once

#include <Eigen/Core>

#include "core/base/complex.hpp"

namespace dwell {

// No loop over pairs is needed. With v_i = (Re A_i, Im A_i, Re B_i, Im B_i), M = Σ_i v_i v_i' and constant matrices
// K_p, q_ij,p = v_i' K_p v_j if D_i = 0, so both sums are traces of products of M and K_p.
class SecondOrder {
 public:
  // One source: A in N/m, B relative, D in N/m. O(1); real-time safe.
  void add(Complex A, Complex B, Complex D) {
    const Eigen::Vector4d v{A.real(), A.imag(), B.real(), B.imag()};
    M_ += v * v.transpose();
    if (D == 0.0) return;
    const Complex own = -A * B, bent = own + D;
    const Eigen::Vector2d before{own.real(), own.imag()}, after{bent.real(), bent.imag()};
    beside_ += after * after.transpose() - before * before.transpose();
    mean_ += after - before;
  }
  // E[p q] of all sources added, (N/m)²: 2 × 2, symmetric. O(1); real-time safe.
  [[nodiscard]] Eigen::Matrix2d mean_product() const {
    Eigen::Matrix4d K[2] = {Eigen::Matrix4d::Zero(), Eigen::Matrix4d::Zero()};
    K[0](0, 2) = K[0](2, 0) = K[1](0, 3) = K[1](3, 0) = K[1](1, 2) = K[1](2, 1) = -0.5;
    K[0](1, 3) = K[0](3, 1) = 0.5;
    Eigen::Matrix2d product = 2 * beside_;
    const Eigen::Vector2d mean = mean_ + Eigen::Vector2d{(K[0] * M_).trace(), (K[1] * M_).trace()};
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q) product(p, q) += 2 * (K[p] * M_ * K[q] * M_).trace() + mean(p) * mean(q);
    return product;
  }

 private:
  Eigen::Matrix4d M_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix2d beside_ = Eigen::Matrix2d::Zero();  // contribution of the D_i to Σ_ij q_ij,p q_ij,q
  Eigen::Vector2d mean_ = Eigen::Vector2d::Zero();    // contribution of the D_i to Σ_i q_ii
};

}  // namespace dwell
