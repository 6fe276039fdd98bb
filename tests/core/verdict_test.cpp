#include "core/verify/verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

ChannelComparison judged(double error, double U, double noise = 0.0, double beyond_steady = 1.0, bool consistent = true,
                         double U_as_is = kNaN) {
  ChannelComparison channel;
  channel.channel = 0;
  channel.error = error;
  channel.U = U;
  channel.U_as_is = std::isfinite(U_as_is) ? U_as_is : U;
  channel.noise = noise;
  channel.beyond_steady = beyond_steady;
  judge(channel, 0.05, consistent);
  return channel;
}

TEST(Verdict, IsAdequateWhereErrorAndUncertaintyTogetherAreWithin) {
  EXPECT_EQ(judged(0.03, 0.019).verdict, Verdict::adequate);
  EXPECT_TRUE(judged(0.03, 0.019).reason.empty());
}

TEST(Verdict, IsNotAdequateWhereTheErrorIsBeyondItsUncertainty) {
  EXPECT_EQ(judged(0.08, 0.02).verdict, Verdict::not_adequate);
  EXPECT_EQ(judged(0.06, 0.02).verdict, Verdict::not_verified);
}

TEST(Verdict, WaitsForBetterEvidenceWhereUncertaintyIsWide) {
  const ChannelComparison wide = judged(0.01, 0.06);
  EXPECT_EQ(wide.verdict, Verdict::not_verified);
  EXPECT_NE(wide.reason.find("too large to decide"), std::string::npos) << wide.reason;
}

TEST(Verdict, HoldsNoNoiseAgainstTheModel) {
  EXPECT_EQ(judged(0.1, 0.01, 0.0995).verdict, Verdict::adequate) << "1 % is not noise";
  EXPECT_EQ(judged(0.1, 0.01, 0.05).verdict, Verdict::not_adequate);
}

TEST(Verdict, CallsNothingAdequateThatNoiseMayHide) {
  const ChannelComparison noisy = judged(0.1, 0.01, 0.0995, 1.0, true, 0.045);
  EXPECT_EQ(noisy.verdict, Verdict::not_verified);
  EXPECT_NE(noisy.reason.find("noise: 10 %"), std::string::npos) << noisy.reason;
}

// Where statistics leave something unexplained, what looks like noise may be the model's.
TEST(Verdict, TakesNoNoiseOffWhereTheCauseOfTheErrorIsNotKnown) {
  EXPECT_EQ(judged(0.1, 0.01, 0.0995, 1.0, false).verdict, Verdict::not_verified);
}

// The model is used with the coefficients that it has.
TEST(Verdict, LetsAModelServeThatPredictsWellWithCoefficientsHardlyKnown) {
  EXPECT_EQ(judged(0.01, 0.3, 0.0, 1.0, true, 0.01).verdict, Verdict::adequate);
  EXPECT_EQ(judged(0.06, 0.3, 0.0, 1.0, true, 0.01).verdict, Verdict::not_verified) << "and condemns no chain for them";
  EXPECT_EQ(judged(0.01, 0.3, 0.0, 1.0, false, 0.01).verdict, Verdict::not_verified);
}

// Any chain with these phasors would predict a steady motion as well.
TEST(Verdict, CallsAPredictionOfTheSteadyMotionNoTest) {
  EXPECT_EQ(judged(0.001, 0.001, 0.0, 0.007).verdict, Verdict::not_verified);
  EXPECT_EQ(judged(0.001, 0.001, 0.0, 0.01).verdict, Verdict::adequate);
}

TEST(Verdict, CountsAnErrorTwiceWhoseCauseIsNotKnown) {
  EXPECT_EQ(judged(0.03, 0.01, 0.0, 1.0, false).verdict, Verdict::not_verified);
  EXPECT_EQ(judged(0.01, 0.01, 0.0, 1.0, false).verdict, Verdict::adequate);
  EXPECT_EQ(judged(0.09, 0.01, 0.0, 1.0, false).verdict, Verdict::not_adequate);
}

TEST(Verdict, SaysNothingOfAChannelInWhichNothingMoves) {
  EXPECT_EQ(judged(kNaN, kNaN).verdict, Verdict::not_verified);
}

TEST(Verdict, OfTheWholeIsThatOfItsWorstChannel) {
  Verification whole;
  whole.channels = {judged(0.01, 0.01), judged(0.03, 0.01)};
  whole.channels[1].channel = 1;
  judge(whole, {"y1", "y2"});
  EXPECT_EQ(whole.verdict, Verdict::adequate);
  EXPECT_EQ(whole.seen, 0.03);
  EXPECT_TRUE(whole.reasons.empty());
  whole.channels.push_back(judged(0.01, 0.09));
  judge(whole, {"y1", "y2"});
  EXPECT_EQ(whole.verdict, Verdict::not_verified);
  EXPECT_EQ(whole.U, 0.09);
  whole.channels.push_back(judged(0.09, 0.01));
  judge(whole, {"y1", "y2"});
  EXPECT_EQ(whole.verdict, Verdict::not_adequate);
  EXPECT_EQ(whole.seen, 0.09);
}

// What any chain of these phasors predicts, neither speaks for the model nor against it.
TEST(Verdict, OfTheWholeIsNotHeldUpByAChannelThatIsNoTestWhereMostAre) {
  Verification whole;
  whole.accuracy = 0.05;
  whole.consistent = true;
  whole.channels = {judged(0.01, 0.01), judged(0.01, 0.01), judged(0.01, 0.01, 0.0, 0.02)};
  for (int c = 0; c < 3; ++c) whole.channels[static_cast<std::size_t>(c)].channel = c;
  ASSERT_EQ(whole.channels[2].verdict, Verdict::not_verified);
  judge(whole, {"y1", "y2", "y3"});
  EXPECT_EQ(whole.verdict, Verdict::adequate);
  EXPECT_EQ(whole.reasons.size(), 1U) << "it is told";
  whole.channels.erase(whole.channels.begin());
  judge(whole, {"y1", "y2", "y3"});
  EXPECT_EQ(whole.verdict, Verdict::not_verified) << "half is not most";
  whole.channels = {judged(0.01, 0.01), judged(0.01, 0.01), judged(0.06, 0.03)};
  judge(whole, {"y1", "y2", "y3"});
  EXPECT_EQ(whole.verdict, Verdict::not_verified) << "beyond the accuracy";
}

}  // namespace
}  // namespace dwell
