#include "core/motion/stride.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

namespace dwell {
namespace {

Stride after(std::initializer_list<double> gains) {
  Stride stride;
  for (const double gain : gains) stride.learn(gain);
  return stride;
}

TEST(Stride, ShortensAFirstStepThatWentTooFarByHalf) { EXPECT_EQ(after({-20.0}).damping(), 0.5); }

TEST(Stride, TakesLessAndLessDampingWhileStepsGainWhatTheyPromised) {
  EXPECT_LT(after({1.0}).damping(), 1e-6);
  EXPECT_NEAR(after({-20.0, 1.0, 1.0}).damping(), 0.005, 1e-12);
}

// One damping goes too far, ten times as much creeps: it does not begin again with half the length.
TEST(Stride, LooksBetweenADampingThatServedAndOneThatWentTooFar) {
  EXPECT_NEAR(after({-20.0, 1.0, 1.0, -3.0}).damping(), std::sqrt(0.05 * 0.005), 1e-12);
  EXPECT_NEAR(after({-20.0, 1.0, 1.0, -3.0, -1.0}).damping(), 0.05, 1e-12) << "then the one that served";
  EXPECT_EQ(after({-20.0, 1.0, 1.0, -3.0, -1.0, -1.0}).damping(), 0.5);
}

TEST(Stride, GoesTwiceAsFarAfterTwoStepsThatFoundTheFunctionFlatter) {
  EXPECT_EQ(after({1.9}).stretch(), 1.0);
  EXPECT_EQ(after({1.9, 1.9}).stretch(), 2.0);
  EXPECT_EQ(after({1.9, 1.4}).stretch(), 1.0) << "half the information's curvature is 1.5";
  EXPECT_EQ(after({1.9, 1.9, 3.6}).stretch(), 2.0) << "a stretched step on a tenth of the curvature gains 3.6";
}

TEST(Stride, PaysForAStretchedStepThatWentTooFarWithTheStretchAlone) {
  const Stride stride = after({1.9, 1.9, -1.0});
  EXPECT_EQ(stride.stretch(), 1.0);
  EXPECT_LT(stride.damping(), 1e-6);
}

TEST(Stride, EndsWhereNoStepGainsAnyMore) {
  Stride stride;
  int steps = 0;
  for (; !stride.spent() && steps < 100; ++steps)
    stride.learn(steps % 2 == 0 ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  EXPECT_LT(steps, 20);
}

}  // namespace
}  // namespace dwell
