// How much of the transient is left, against how much may be left.
#include "core/transient/transient_left.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

constexpr double kAllowed = 0.005;

struct LeftMotion : FreeMotion {
  TransientLeft left{kAllowed, fit, noise};

  // So long a motion, fitted by its true pole from the second period on.
  LeftMotion(std::uint64_t seed, double length_s) : FreeMotion(seed) {
    play(length_s);
    learn_noise();
    fit_all(kPeriodLength_s, std::vector<Complex>{kMode});
    noise.compare_halves(fit, now().now_ns);
  }
};

TEST(TransientLeft, DecaysAsTheModeDoesAndNamesTheChannelThatHasMostOfIt) {
  LeftMotion motion(1, 8);
  const auto at_2 = motion.left.at(to_ns(2), motion.now()), at_4 = motion.left.at(to_ns(4), motion.now());
  EXPECT_EQ(at_2.channel, 1);
  // 0.6 exp(-0.5 t) of 0.85 times the tolerance of an amplitude of 1.
  EXPECT_NEAR(at_2.left, 0.6 * std::exp(-1.0) / (0.85 * kAllowed), 0.05 * at_2.left);
  EXPECT_NEAR(at_4.left / at_2.left, std::exp(-1.0), 0.02);
}

TEST(TransientLeft, AsksMoreOfReadingsWhoseRoundingHidesTheirNoise) {
  LeftMotion motion(2, 8);
  const double before = motion.left.at(to_ns(4), motion.now()).left;
  EXPECT_FALSE(motion.left.rounded(motion.now()));
  motion.channels[1].step = 10 * FreeMotion::kRms;
  EXPECT_TRUE(motion.left.rounded(motion.now()));
  EXPECT_NEAR(motion.left.at(to_ns(4), motion.now()).left / before, 0.85 / 0.80, 1e-9);
}

TEST(TransientLeft, KnowsNothingWhileAWatchedChannelIsNotFitted) {
  LeftMotion motion(3, 4);
  motion.channels[1].watched = false;
  motion.fit_all(FreeMotion::kPeriodLength_s, std::vector<Complex>{FreeMotion::kMode});
  EXPECT_TRUE(std::isfinite(motion.left.at(to_ns(4), motion.now()).left));
  motion.channels[1].watched = true;
  EXPECT_EQ(motion.left.at(to_ns(4), motion.now()).left, INFINITY);
}

TEST(TransientLeft, OfAnImposedMotionNothingIsAsked) {
  LeftMotion motion(4, 4);
  for (FittedChannel& channel : motion.channels) channel.imposed = true;
  const auto worst = motion.left.at(to_ns(1), motion.now());
  EXPECT_EQ(worst.left, 0.0);
  EXPECT_EQ(worst.channel, -1);
  SettlingDetector::Verdict verdict{.worst_channel = 7};
  motion.left.tell(to_ns(1), motion.now(), verdict);
  EXPECT_EQ(verdict.worst_left, 0.0);
  EXPECT_EQ(verdict.worst_channel, 7);
}

TEST(TransientLeft, WhatIsNotExplainedCountsAsLeft) {
  LeftMotion motion(5, 16);
  EXPECT_LT(motion.left.at(to_ns(16), motion.now()).left, 0.15);
  // Noise of half the rms: the rest of the residuals may be a transient.
  motion.noise.begin_hold();
  for (int c = 0; c < 2; ++c) motion.noise.learn(c, 0.25 * 4000 * FreeMotion::kRms * FreeMotion::kRms, 4000);
  const auto worst = motion.left.at(to_ns(16), motion.now());
  const double power = motion.noise.unexplained(worst.channel, motion.fit.fit(), motion.now());
  EXPECT_NEAR(power, 0.75 * FreeMotion::kRms * FreeMotion::kRms, 0.1 * FreeMotion::kRms * FreeMotion::kRms);
  EXPECT_NEAR(worst.left, std::sqrt(2 * power) / kAllowed, 0.01 * worst.left);
}

TEST(TransientLeft, DataCountFromTheEarliestInstantAtWhichAVerdictWouldHaveBeenRight) {
  LeftMotion motion(6, 16);
  const HoldNow now = motion.now();
  const auto from_ns = motion.left.counts_from(now.now_ns, now);
  ASSERT_TRUE(from_ns);
  EXPECT_LE(motion.left.at(*from_ns, now).left, 1.0);
  EXPECT_GT(motion.left.at(*from_ns - to_ns(now.period_s() / kQuarters), now).left, 1.0);
}

TEST(TransientLeft, FewerThanSixQuartersAreNoDwell) {
  LeftMotion motion(7, 4);  // at the end 19 times what is allowed is left
  EXPECT_FALSE(motion.left.counts_from(motion.now().now_ns, motion.now()));
}

TEST(TransientLeft, AVerdictWasPrematureWhereTheSwingWasClearlyMoreThanIsAllowed) {
  LeftMotion motion(8, 16);
  const auto early = motion.left.premature(to_ns(2), motion.now());
  ASSERT_TRUE(early);
  EXPECT_EQ(early->verdict_ns, to_ns(2));
  EXPECT_EQ(early->channel, 1);
  EXPECT_GT(early->left, 10.0);
  EXPECT_FALSE(motion.left.premature(to_ns(14), motion.now()));
}

}  // namespace
}  // namespace dwell
