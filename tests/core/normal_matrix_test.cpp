// Σ x x', summed in fours and without regressors that are zero.
#include "core/transient/normal_matrix.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace dwell {
namespace {

constexpr Eigen::Index kMost = 11, kUsed = 9;

// The same products in the same order, one element at a time.
struct PlainSum {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kUsed, kUsed), four = Eigen::MatrixXd::Zero(kUsed, 4);
  Eigen::Index count = 0;

  void add(const Eigen::VectorXd& x) {
    if (count == 4) complete();
    four.col(count++) = x.head(kUsed);
  }
  void complete() {
    for (Eigen::Index j = 0; j < kUsed; ++j)
      for (Eigen::Index i = j; i < kUsed; ++i)
        sum(i, j) +=
            (four(j, 0) * four(i, 0) + four(j, 1) * four(i, 1)) + (four(j, 2) * four(i, 2) + four(j, 3) * four(i, 3));
    four.setZero();
    count = 0;
  }
};

TEST(NormalMatrix, IsTheSumOfAllProductsBitForBitWhicheverRegressorsAreZero) {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution is_zero(0.5), for_long(0.9);
  for (int trial = 0; trial < 200; ++trial) {
    NormalMatrix matrix(kMost);
    matrix.clear();
    PlainSum plain;
    std::array<bool, kUsed> zero{};
    for (int i = 0; i < trial % 23; ++i) {
      Eigen::VectorXd x(kMost);
      for (Eigen::Index k = 0; k < kUsed; ++k) {
        bool& of = zero[static_cast<std::size_t>(k)];
        if (!for_long(rng)) of = is_zero(rng);
        x(k) = of ? (k % 2 == 0 ? 0.0 : -0.0) : normal(rng);
      }
      matrix.add(x, kUsed);
      plain.add(x);
    }
    matrix.complete(kUsed);
    plain.complete();
    for (Eigen::Index j = 0; j < kUsed; ++j)
      EXPECT_EQ(matrix.sum().col(j).segment(j, kUsed - j), plain.sum.col(j).segment(j, kUsed - j)) << trial;
  }
}

TEST(NormalMatrix, WithoutItsNewestSampleItGoesOnAsIfThatHadNotBeen) {
  std::mt19937_64 rng(2);
  std::normal_distribution<double> normal;
  for (int samples = 1; samples < 12; ++samples) {
    NormalMatrix whole(kMost), without(kMost), copy(kMost);
    whole.clear();
    without.clear();
    const auto next = [&] {
      Eigen::VectorXd x(kMost);
      for (double& each : x) each = normal(rng);
      return x;
    };
    for (int i = 0; i < samples; ++i) {
      const Eigen::VectorXd x = next();
      whole.add(x, kUsed);
      if (i + 1 < samples) without.add(x, kUsed);
    }
    copy.take_all_but_newest(whole, kUsed);
    for (int i = 0; i < 6; ++i) {
      const Eigen::VectorXd x = next();
      without.add(x, kUsed);
      copy.add(x, kUsed);
    }
    without.complete(kUsed);
    copy.complete(kUsed);
    for (Eigen::Index j = 0; j < kUsed; ++j)
      EXPECT_EQ(copy.sum().col(j).segment(j, kUsed - j), without.sum().col(j).segment(j, kUsed - j)) << samples;
  }
}

}  // namespace
}  // namespace dwell
