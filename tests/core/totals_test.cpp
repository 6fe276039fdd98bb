#include "core/fit/totals.hpp"

#include <gtest/gtest.h>

#include <array>

namespace dwell {
namespace {

// The sets of one sample at the instant from which a set of one harmonic counts, with the reading 2.
struct OneSample {
  OneSample() {
    moments::Regressors now;
    moments::evaluate<1>(0.0, 0.0, now);
    moments::add<3>(now, 1.0, 0.0, instants.data());
    moments::add<2>(now, 2.0, 4.0, readings.data());
  }
  [[nodiscard]] ChannelMoments sets() const { return {instants.data(), readings.data()}; }
  std::array<double, moments::size(3)> instants{};
  std::array<double, moments::size(2)> readings{};
};

TEST(Totals, ChannelsThatAlwaysShareHaveOneSetOfInstants) {
  const OneSample sample;
  Totals totals(2, 1);
  totals.restart(1.0, 0);
  for (int block = 0; block < 3; ++block) {
    for (int c = 0; c < 2; ++c) totals.share(c, 0);
    for (int c = 0; c < 2; ++c) totals.add(c, sample.sets(), totals.turn_from(1.0, 0));
  }
  EXPECT_EQ(totals.channel(1).instants, totals.channel(0).instants);
  EXPECT_EQ(totals.channel(1).instants[0], 3.0);
  EXPECT_EQ(totals.channel(1).readings[0], 6.0);
}

TEST(Totals, AChannelThatSharesNoLongerTakesWhatItSharedAlong) {
  const OneSample sample;
  Totals totals(2, 1);
  totals.restart(1.0, 0);
  for (int c = 0; c < 2; ++c) totals.share(c, 0);
  for (int c = 0; c < 2; ++c) totals.add(c, sample.sets(), totals.turn_from(1.0, 0));
  // Channel 1 has a block of its own, and channel 0 none.
  totals.share(1, 1);
  totals.add(1, sample.sets(), totals.turn_from(1.0, 0));
  EXPECT_EQ(totals.channel(0).instants[0], 1.0);
  EXPECT_EQ(totals.channel(1).instants[0], 2.0);
}

TEST(Totals, TheCentroidIsTheMeanInstantAndTheReferenceWhereThereIsNone) {
  const OneSample sample;
  Totals totals(2, 1);
  totals.restart(1.0, 5'000'000'000);
  totals.share(0, 0);
  totals.add(0, sample.sets(), totals.turn_from(1.0, 6'000'000'000));
  totals.add(0, sample.sets(), totals.turn_from(1.0, 9'000'000'000));
  EXPECT_NEAR(static_cast<double>(totals.centroid_ns(0)), 7.5e9, 2.0);
  EXPECT_EQ(totals.centroid_ns(1), 5'000'000'000);
}

TEST(Totals, OneChannelRestartedLeavesTheOthers) {
  const OneSample sample;
  Totals totals(2, 1);
  totals.restart(1.0, 0);
  for (int c = 0; c < 2; ++c) totals.share(c, c);
  for (int c = 0; c < 2; ++c) totals.add(c, sample.sets(), totals.turn_from(1.0, 0));
  totals.restart_channel(1, 1.0, 0);
  EXPECT_EQ(totals.channel(0).readings[0], 2.0);
  EXPECT_EQ(totals.channel(1).readings[0], 0.0);
  EXPECT_EQ(totals.channel(1).instants[0], 0.0);
}

}  // namespace
}  // namespace dwell
