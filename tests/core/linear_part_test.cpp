#include "core/transient/linear_part.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/core/modal_channel.hpp"

namespace dwell {
namespace {

const ModalChannel::Poles kOnePole{{-0.5, 33.0}};

TEST(LinearPart, FindsTheAmplitudesThatAreThere) {
  ModalChannel channel({kOnePole, {{0.7, 0.3}}, 0.0, 2.0}, kOnePole);
  ASSERT_TRUE(channel.solve(1e3));
  EXPECT_NEAR(channel.solution.theta(channel.layout().sine(1)), 2.0, 1e-6);
  EXPECT_NEAR(channel.solution.theta(channel.layout().cosine(1)), 0.0, 1e-6);
  EXPECT_LT((channel.solution.amplitude(channel.layout(), 0) - Eigen::Vector2d{0.7, 0.3}).norm(), 1e-6);
}

TEST(LinearPart, TheStatedCovarianceIsThatOfTheAmplitudesAndTheNoiseThatOfTheData) {
  double chi2 = 0.0, sigma2 = 0.0;
  constexpr int kTrials = 300;
  for (int trial = 1; trial <= kTrials; ++trial) {
    ModalChannel channel({kOnePole, {{0.7, 0.3}}, 0.05, 2.0}, kOnePole, static_cast<std::uint64_t>(trial));
    ASSERT_TRUE(channel.solve());
    const Eigen::Vector2d off = channel.solution.amplitude(channel.layout(), 0) - Eigen::Vector2d{0.7, 0.3};
    chi2 += off.dot(channel.solution.amplitude_covariance(0).inverse() * off) / (2 * kTrials);
    sigma2 += channel.solution.sigma2 / kTrials;
  }
  EXPECT_NEAR(chi2, 1.0, 0.2) << "600 degrees of freedom: a relative spread of 0.06";
  EXPECT_NEAR(sigma2, 0.05 * 0.05, 0.02 * 0.05 * 0.05);
}

TEST(LinearPart, AnAmplitudeIsNotBelievedToBeLargerThanItsPrior) {
  // A mode so near the drive that 0.6 s do not tell one from the other.
  const ModalChannel::Poles near{{-0.05, 1.001 * ModalChannel::kOmega}};
  ModalChannel channel({{}, {}, 0.1, 0.6}, near);
  ASSERT_TRUE(channel.solve(0.01));
  EXPECT_LT(channel.solution.amplitude(channel.layout(), 0).norm(), 0.02);
  EXPECT_NEAR(std::sqrt(channel.solution.amplitude_variance(0)), 0.01, 0.002);
}

TEST(LinearPart, FewerSamplesThanParametersAreNoFit) {
  ModalChannel channel({kOnePole, {{0.7, 0.3}}, 0.0, 0.04}, kOnePole);  // eight samples of five parameters
  EXPECT_FALSE(channel.solve());
  EXPECT_FALSE(channel.solution.usable);
}

TEST(LinearPart, WhatIsLeftOfTheDerivativesIsTheSchurComplement) {
  ModalChannel channel({kOnePole, {{0.7, 0.3}}, 0.01, 2.0}, kOnePole);
  const ModalLayout& layout = channel.layout();
  ASSERT_TRUE(channel.eliminate());
  const Eigen::MatrixXd all =
      channel.sums.normal().topLeftCorner(layout.all(), layout.all()).selfadjointView<Eigen::Lower>();
  const Eigen::Index P = layout.linear(), D = layout.slopes();
  const Eigen::MatrixXd taken_over = all.topLeftCorner(P, P).lu().solve(all.topRightCorner(P, D));
  const Eigen::MatrixXd beyond = all.bottomRightCorner(D, D) - all.bottomLeftCorner(D, P) * taken_over;
  EXPECT_LT((Eigen::MatrixXd(channel.linear.beyond(layout)) - beyond).norm(), 1e-6 * beyond.norm());
  EXPECT_LT((Eigen::MatrixXd(channel.linear.taken_over(layout)) - taken_over).norm(), 1e-6 * taken_over.norm());
}

}  // namespace
}  // namespace dwell
