// The fit on the samples of a hold.
#include "core/transient/hold_fit.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

const std::vector<Complex> kTrueMode{FreeMotion::kMode};

TEST(HoldFit, SeesEachSampleOnceHoweverOftenItIsFed) {
  FreeMotion motion(1);
  motion.play(4);
  motion.fit_all(1.0, kTrueMode);
  EXPECT_EQ(motion.fit.fit().samples(0), 3 * FreeMotion::kSamples_hz);
  motion.fit.feed(motion.channels);
  motion.fit.solve(motion.channels);
  EXPECT_EQ(motion.fit.fit().samples(0), 3 * FreeMotion::kSamples_hz);
  motion.play(1);
  motion.fit.feed(motion.channels);
  motion.fit.solve(motion.channels);
  EXPECT_EQ(motion.fit.fit().samples(0), 4 * FreeMotion::kSamples_hz);
}

TEST(HoldFit, LeavesOutAChannelThatIsNotWatched) {
  FreeMotion motion(2);
  motion.channels[1].watched = false;
  motion.play(4);
  motion.fit_all(1.0, kTrueMode);
  EXPECT_TRUE(motion.fit.fit().usable(0));
  EXPECT_FALSE(motion.fit.fit().usable(1));
}

TEST(HoldFit, LeavesOutAnswersThatWereHeldUp) {
  FreeMotion motion(3);
  motion.play(2);
  for (int c = 0; c < 2; ++c) motion.history.push(to_ns(2.0), c, 100.0, true);
  motion.seconds = 2.0 + 1 / FreeMotion::kSamples_hz;
  motion.play(2);
  motion.fit_all(1.0, kTrueMode);
  EXPECT_EQ(motion.fit.fit().samples(0), 3 * FreeMotion::kSamples_hz);
  EXPECT_LT(motion.fit.fit().variance(0), 2 * FreeMotion::kRms * FreeMotion::kRms);
  motion.fit.each_residual(to_ns(1.0), [](const SampleHistory::Sample& sample, double residual) {
    EXPECT_FALSE(sample.held_up);
    EXPECT_LT(std::abs(residual), 10 * FreeMotion::kRms);
  });
}

TEST(HoldFit, GivesAnImposedMotionNoTransient) {
  FreeMotion motion(3);
  motion.channels[0].imposed = true;
  motion.play(4);
  motion.fit_all(0.2, kTrueMode);
  EXPECT_LT(std::abs(motion.fit.fit().amplitude(0, 0)), 1e-6);
  EXPECT_NEAR(std::abs(motion.fit.fit().amplitude(1, 0)), 0.6 * std::exp(-0.5 * 0.2), 0.01);
}

TEST(HoldFit, BelievesOtherPolesOnlyWhereTheyExplainTheDataBetter) {
  FreeMotion motion(4);
  motion.play(4);
  double misfit = motion.fit_all(0.2, std::vector<Complex>{{-0.6, 33.5}});
  const double before = misfit;
  EXPECT_TRUE(motion.fit.attempt(FreeMotion::kDrive, kTrueMode, motion.channels, misfit));
  EXPECT_LT(misfit, before);
  EXPECT_EQ(motion.fit.fit().misfit(), misfit);
  const double best = misfit;
  EXPECT_FALSE(motion.fit.attempt(FreeMotion::kDrive, std::vector<Complex>{{-0.4, 32.5}}, motion.channels, misfit));
  EXPECT_EQ(misfit, best);
  EXPECT_EQ(motion.fit.fit().misfit(), best);
  EXPECT_EQ(motion.fit.fit().poles()[0], FreeMotion::kMode);
}

TEST(HoldFit, CountsTheFitsThatAreAllowed) {
  FreeMotion motion(5);
  motion.play(4);
  motion.fit.allow(2);
  motion.fit_all(0.2, kTrueMode);
  EXPECT_TRUE(motion.fit.may_fit());
  motion.fit_all(0.2, kTrueMode);
  EXPECT_FALSE(motion.fit.may_fit());
  motion.fit.allow_at_least(1);
  EXPECT_TRUE(motion.fit.may_fit());
}

TEST(HoldFit, AffordsFewerFitsOfALongerHoldButNeverLessThanFour) {
  FreeMotion motion(6);
  motion.play(4);
  motion.fit.begin_at(0);
  const int of_short = motion.fit.affordable(2);
  motion.play(36);
  EXPECT_NEAR(of_short / 10.0, motion.fit.affordable(2), 1.0);
  EXPECT_EQ(motion.fit.affordable(2000), 4);
}

TEST(HoldFit, IsNotDeterminedByFewReadingsMoreThanRegressors) {
  FreeMotion motion(7);
  motion.play(0.04);  // 16 readings of each channel, five regressors
  motion.fit_all(0.0, kTrueMode);
  ASSERT_TRUE(motion.fit.fit().usable(1));
  EXPECT_FALSE(motion.fit.determined());
  motion.play(0.04);
  motion.fit.feed(motion.channels);
  motion.fit.solve(motion.channels);
  EXPECT_TRUE(motion.fit.determined());
}

TEST(HoldFit, OfSeveralModesTheSlowestSetsTheRateAndSteadyLinesDoNot) {
  FreeMotion motion(8);
  motion.play(4);
  motion.fit_all(0.2, std::vector<Complex>{{-2.0, 60.0}, FreeMotion::kMode, {0.0, 314.0}});
  EXPECT_EQ(motion.fit.slowest_rate(), 0.5);
  motion.fit_all(0.2, {});
  EXPECT_EQ(motion.fit.slowest_rate(), INFINITY);
}

}  // namespace
}  // namespace dwell
