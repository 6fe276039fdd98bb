// Is what the fit of natural oscillations leaves over noise?
#include "core/transient/residual_noise.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

const std::vector<Complex> kWholeMotion{FreeMotion::kMode};

TEST(ResidualNoise, KnowsAVarianceOnceItHasFourDegreesOfFreedom) {
  ResidualNoise noise(1);
  EXPECT_EQ(noise.variance(0), INFINITY);
  noise.learn(0, 3.0, 3.0);
  EXPECT_FALSE(noise.known(0));
  noise.learn(0, 6.0, 3.0);
  EXPECT_TRUE(noise.known(0));
  EXPECT_DOUBLE_EQ(noise.variance(0), 1.5);
  noise.begin_hold();
  EXPECT_FALSE(noise.known(0));
  EXPECT_EQ(noise.variance(0), INFINITY);
}

TEST(ResidualNoise, TheNewestPeriodCountsAnEighthOfAllAtLeast) {
  ResidualNoise noise(1);
  for (int i = 0; i < 1000; ++i) noise.learn(0, 10.0, 10.0);
  noise.learn(0, 100.0, 10.0);
  EXPECT_NEAR(noise.variance(0), (8 * 1.0 + 10.0) / 9, 1e-12);
}

TEST(ResidualNoise, TheRightPolesLeaveNoiseAndNothingElse) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    FreeMotion motion(seed);
    motion.play(4);
    motion.learn_noise();
    motion.fit_all(0.2, kWholeMotion);
    motion.noise.compare_halves(motion.fit, motion.now().now_ns);
    EXPECT_TRUE(motion.noise.explained(motion.fit.fit(), motion.now())) << seed;
  }
}

TEST(ResidualNoise, WithoutTheModeTheResidualsExceedTheNoise) {
  FreeMotion motion(1);
  motion.play(4);
  motion.learn_noise();
  motion.fit_all(0.2, {});
  EXPECT_FALSE(motion.noise.explained(motion.fit.fit(), motion.now()));
  const double power = motion.noise.unexplained(1, motion.fit.fit(), motion.now());
  EXPECT_GT(power, 100 * FreeMotion::kRms * FreeMotion::kRms);
  EXPECT_LT(power, motion.fit.fit().variance(1));
}

// Where the noise is not known the residuals' decay alone tells.
TEST(ResidualNoise, WhatDecaysIsNoNoiseEvenWhereTheNoiseIsNotKnown) {
  FreeMotion motion(2);
  motion.play(6);
  motion.fit_all(0.2, {});
  EXPECT_TRUE(motion.noise.explained(motion.fit.fit(), motion.now())) << "the halves have not been looked at";
  motion.noise.compare_halves(motion.fit, motion.now().now_ns);
  EXPECT_FALSE(motion.noise.explained(motion.fit.fit(), motion.now()));
}

TEST(ResidualNoise, AnImposedMotionNeedsNoExplanation) {
  FreeMotion motion(3);
  for (FittedChannel& channel : motion.channels) channel.imposed = true;
  motion.play(4);
  motion.learn_noise();
  motion.fit_all(0.2, kWholeMotion);
  EXPECT_TRUE(motion.noise.explained(motion.fit.fit(), motion.now()));
}

// Instants off by ± h shift the reading by up to |ω X h|.
TEST(ResidualNoise, InstantsThatAreKnownToAFewMillisecondsExplainResidualsOfTheirOwn) {
  FreeMotion motion(4);
  std::uniform_real_distribution<double> late(-0.004, 0.004);
  motion.play(4, [&](int c, double t) {
    const double off = late(motion.random);
    return std::sin(FreeMotion::kDrive * (t + off) + c) - std::sin(FreeMotion::kDrive * t + c);
  });
  motion.learn_noise();
  motion.fit_all(0.2, kWholeMotion);
  EXPECT_FALSE(motion.noise.explained(motion.fit.fit(), motion.now()));
  for (FittedChannel& channel : motion.channels) channel.refresh_half_s = 0.0045;
  EXPECT_TRUE(motion.noise.explained(motion.fit.fit(), motion.now()));
}

}  // namespace
}  // namespace dwell
