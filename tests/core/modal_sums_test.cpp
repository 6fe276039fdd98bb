#include "core/transient/modal_sums.hpp"

#include <gtest/gtest.h>

#include <random>

namespace dwell {
namespace {

TEST(ModalSums, AreThoseOfTheProductsHoweverManySamplesThereAre) {
  constexpr Eigen::Index kMost = 7, kUsed = 5;
  for (int samples = 1; samples <= 13; ++samples) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(samples));
    std::normal_distribution<double> normal;
    ModalSums sums(kMost);
    sums.clear();
    Eigen::MatrixXd normal_matrix = Eigen::MatrixXd::Zero(kUsed, kUsed);
    Eigen::VectorXd moments = Eigen::VectorXd::Zero(kUsed);
    double squares = 0.0, first = 0.0;
    for (int i = 0; i < samples; ++i) {
      Eigen::VectorXd x(kMost);
      for (double& each : x) each = normal(rng);
      const double value = 1e6 + normal(rng);
      if (i == 0) first = value;
      const Eigen::VectorXd used = x.head(kUsed);
      normal_matrix += used * used.transpose();
      moments += (value - first) * used;
      squares += (value - first) * (value - first);
      sums.add(x, kUsed, value);
    }
    sums.complete(kUsed);
    EXPECT_EQ(sums.reference(), first);
    EXPECT_EQ(sums.samples(), samples);
    EXPECT_NEAR(sums.squares(), squares, 1e-9);
    EXPECT_LT((sums.moments().head(kUsed) - moments).norm(), 1e-9);
    for (Eigen::Index i = 0; i < kUsed; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) EXPECT_NEAR(sums.normal()(i, j), normal_matrix(i, j), 1e-9);
  }
}

TEST(ModalSums, ClearedTheyTakeANewReference) {
  ModalSums sums(2);
  sums.clear();
  sums.add(Eigen::Vector2d{1.0, 2.0}, 2, 7.0);
  sums.clear();
  sums.add(Eigen::Vector2d{1.0, 2.0}, 2, 9.0);
  sums.add(Eigen::Vector2d{1.0, 0.0}, 2, 10.0);
  sums.complete(2);
  EXPECT_EQ(sums.reference(), 9.0);
  EXPECT_EQ(sums.samples(), 2.0);
  EXPECT_EQ(sums.moments()(0), 1.0);
  EXPECT_EQ(sums.normal()(0, 0), 2.0);
  EXPECT_EQ(sums.normal()(1, 0), 2.0);
}

}  // namespace
}  // namespace dwell
