// What errors do to an element to second order, against the sums over pairs and against draws.
#include "core/chain/second_order.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace dwell {
namespace {

struct ThreeErrors {
  std::vector<Complex> A, B, D;
  SecondOrder sum;
};

ThreeErrors three_errors() {
  ThreeErrors out{
      {{3.0, 1.0}, {-2.0, 0.5}, {0.3, -4.0}}, {{0.1, -0.2}, {0.3, 0.4}, {-0.2, 0.1}}, {{0.5, 0.2}, 0.0, -1.0}, {}};
  for (std::size_t i = 0; i < out.A.size(); ++i) out.sum.add(out.A[i], out.B[i], out.D[i]);
  return out;
}

// q_ij of the header.
Complex pair_of_errors(const ThreeErrors& of, std::size_t i, std::size_t j) {
  return -0.5 * (of.A[i] * of.B[j] + of.A[j] * of.B[i]) + (i == j ? of.D[i] : 0.0);
}

TEST(SecondOrder, IsNothingWithoutErrorsAndWhereTheDeformationIsExact) {
  SecondOrder sum;
  EXPECT_TRUE(sum.mean_product().isZero(0));
  sum.add({3.0, 2.0}, 0.0, 0.0);
  sum.add({-1.0, 5.0}, 0.0, 0.0);
  EXPECT_TRUE(sum.mean_product().isZero(0));
}

// E[(q t²)²] = 3 q².
TEST(SecondOrder, OfOneErrorIsThreeTimesItsSquare) {
  const Complex A{3.0, 1.0}, B{0.1, -0.2}, D{0.5, 0.2}, q = D - A * B;
  SecondOrder sum;
  sum.add(A, B, D);
  const Eigen::Matrix2d product = sum.mean_product();
  EXPECT_NEAR(product(0, 0), 3 * q.real() * q.real(), 1e-12);
  EXPECT_NEAR(product(1, 1), 3 * q.imag() * q.imag(), 1e-12);
  EXPECT_NEAR(product(0, 1), 3 * q.real() * q.imag(), 1e-12);
  EXPECT_EQ(product(0, 1), product(1, 0));
}

TEST(SecondOrder, IsTheSumOverAllPairsOfErrors) {
  const ThreeErrors errors = three_errors();
  Eigen::Matrix2d pairs = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const Complex q = pair_of_errors(errors, i, j);
      const Eigen::Vector2d parts{q.real(), q.imag()};
      pairs += 2 * parts * parts.transpose();
      if (i == j) mean += parts;
    }
  EXPECT_LT((errors.sum.mean_product() - pairs - mean * mean.transpose()).norm(), 1e-12);
}

TEST(SecondOrder, IsTheMeanProductOfWhatDrawnErrorsDo) {
  const ThreeErrors errors = three_errors();
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 200000;
  Eigen::Matrix2d seen = Eigen::Matrix2d::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    const double t[] = {normal(rng), normal(rng), normal(rng)};
    Complex off = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) off += pair_of_errors(errors, i, j) * t[i] * t[j];
    const Eigen::Vector2d parts{off.real(), off.imag()};
    seen += parts * parts.transpose() / kDraws;
  }
  const Eigen::Matrix2d stated = errors.sum.mean_product();
  // The square of a product of normal numbers spreads by some five times its mean: 5/√N = 1 %, four of them.
  EXPECT_LT((seen - stated).norm(), 0.04 * stated.norm());
}

}  // namespace
}  // namespace dwell
