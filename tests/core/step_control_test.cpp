#include "core/motion/step_control.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

namespace dwell {
namespace {

StepControl after(std::initializer_list<double> gains) {
  StepControl control;
  for (const double gain : gains) control.learn(gain);
  return control;
}

TEST(StepControl, StartsWithADampingOfOneHalfAfterAFirstStepThatWentTooFar) {
  EXPECT_EQ(after({-20.0}).damping(), 0.5);
}

TEST(StepControl, TakesLessAndLessDampingWhileStepsGainWhatTheyPromised) {
  EXPECT_LT(after({1.0}).damping(), 1e-6);
  EXPECT_NEAR(after({-20.0, 1.0, 1.0}).damping(), 0.005, 1e-12);
}

// One damping goes too far, ten times as much creeps: it does not begin again with half the length.
TEST(StepControl, LooksBetweenADampingThatServedAndOneThatWentTooFar) {
  EXPECT_NEAR(after({-20.0, 1.0, 1.0, -3.0}).damping(), std::sqrt(0.05 * 0.005), 1e-12);
  EXPECT_NEAR(after({-20.0, 1.0, 1.0, -3.0, -1.0}).damping(), 0.05, 1e-12) << "then the one that served";
  EXPECT_EQ(after({-20.0, 1.0, 1.0, -3.0, -1.0, -1.0}).damping(), 0.5);
}

TEST(StepControl, GoesTwiceAsFarAfterTwoStepsThatFoundTheFunctionFlatter) {
  EXPECT_EQ(after({1.9}).factor(), 1.0);
  EXPECT_EQ(after({1.9, 1.9}).factor(), 2.0);
  EXPECT_EQ(after({1.9, 1.4}).factor(), 1.0) << "half the information's curvature is 1.5";
  EXPECT_EQ(after({1.9, 1.9, 3.6}).factor(), 2.0) << "a doubled step on a tenth of the curvature gains 3.6";
}

TEST(StepControl, PaysForADoubledStepThatWentTooFarWithTheFactorAlone) {
  const StepControl control = after({1.9, 1.9, -1.0});
  EXPECT_EQ(control.factor(), 1.0);
  EXPECT_LT(control.damping(), 1e-6);
}

TEST(StepControl, EndsWhereNoStepGainsAnyMore) {
  StepControl control;
  int steps = 0;
  for (; !control.spent() && steps < 100; ++steps)
    control.learn(steps % 2 == 0 ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  EXPECT_LT(steps, 20);
}

}  // namespace
}  // namespace dwell
