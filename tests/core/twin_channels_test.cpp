// Two channels on one transducer are told from two that move alike.
#include "core/dwell/twin_channels.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

// Noise of 0.01 mm in 400 readings: u of a mean 5e-4 mm, of either component of a phasor 7.1e-4 mm.
ChannelResult result_of(double mean_mm, std::complex<double> X_mm) {
  ChannelResult out;
  out.fit.usable = true;
  out.fit.samples = 400;
  out.fit.mean = 1e-3 * mean_mm;
  out.fit.X[0] = 1e-3 * X_mm;
  out.fit.sigma2 = 1e-10;
  out.fit.covariance = Eigen::Matrix2d::Identity() * 2e-10 / 400;
  return out;
}

Rig rig_of_two(int at, int other) {
  Rig rig;
  rig.channels.resize(2);
  rig.channels[0].name = "y1";
  rig.channels[1].name = "y2";
  rig.channels[0].at = at;
  rig.channels[1].at = other;
  for (Channel& channel : rig.channels) channel.si_per_unit = 1e-3;
  return rig;
}

TEST(TwinChannels, AreThoseWhoseMeanAndMotionDifferByNoiseAlone) {
  const std::vector<ChannelResult> twins = {result_of(3.0, {1.0, 0.5}), result_of(3.001, {1.001, 0.499})};
  const auto doubts = twin_channels(rig_of_two(1, 2), twins);
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_TRUE(doubts[0].elements.empty()) << "all are concerned";
  EXPECT_EQ(
      doubts[0].what,
      "y1 and y2 read the same: the device's numbers are 3.0000 ± 0.0010 and 3.0010 ± 0.0010 in the mean, and swing "
      "alike within noise. Do both channels show one transducer?");
}

TEST(TwinChannels, AreFoundWhateverScaleAndOffsetTheRigFileHas) {
  Rig rig = rig_of_two(1, 2);
  rig.channels[1].scale = 2.0;
  rig.channels[1].offset = -1.0;
  ChannelResult second = result_of(2 * 3.0 - 1.0, {2.0, 1.0});
  second.fit.sigma2 *= 4;
  second.fit.covariance *= 4;
  EXPECT_EQ(twin_channels(rig, std::vector<ChannelResult>{result_of(3.0, {1.0, 0.5}), second}).size(), 1U);
}

TEST(TwinChannels, AreNotTheEndsOfAStiffElement) {
  const std::vector<ChannelResult> stiff = {result_of(3.0, {1.0, 0.5}), result_of(3.01, {1.001, 0.499})};
  EXPECT_TRUE(twin_channels(rig_of_two(1, 2), stiff).empty()) << "their means differ by 14 standard deviations";
  const std::vector<ChannelResult> zeroed = {result_of(0.01, {1.0, 0.5}), result_of(0.0105, {1.001, 0.499})};
  EXPECT_TRUE(twin_channels(rig_of_two(1, 2), zeroed).empty()) << "both are set to zero: their means tell nothing";
}

TEST(TwinChannels, AreNotChannelsThatMoveDifferently) {
  const std::vector<ChannelResult> apart = {result_of(3.0, {1.0, 0.5}), result_of(3.0, {1.005, 0.5})};
  EXPECT_TRUE(twin_channels(rig_of_two(1, 2), apart).empty());
}

TEST(TwinChannels, AreNotTwoTransducersAtOnePlace) {
  const std::vector<ChannelResult> twins = {result_of(3.0, {1.0, 0.5}), result_of(3.0, {1.0, 0.5})};
  EXPECT_TRUE(twin_channels(rig_of_two(1, 1), twins).empty());
}

TEST(TwinChannels, AreNotJudgedWhereAChannelIsWithheld) {
  std::vector<ChannelResult> twins = {result_of(3.0, {1.0, 0.5}), result_of(3.0, {1.0, 0.5})};
  twins[1].withheld = "overrange";
  EXPECT_TRUE(twin_channels(rig_of_two(1, 2), twins).empty());
}

}  // namespace
}  // namespace dwell
