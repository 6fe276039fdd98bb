#include "core/drive/train_begin.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace dwell {
namespace {

// Pulses at these instants, in ms, of a drive that is looked for between 3.9 and 4.1 Hz.
TrainBegin waiting_pulses(std::initializer_list<std::int64_t> at_ms) {
  TrainBegin begin(3.9, 4.1);
  for (const std::int64_t ms : at_ms) begin.add(1'000'000 * ms);
  return begin;
}

TEST(TrainBegin, FourInStepHaveThePeriodOfTheirMeanDistance) {
  const auto period_s = waiting_pulses({1000, 1250, 1502, 1750}).period_s();
  ASSERT_TRUE(period_s);
  EXPECT_DOUBLE_EQ(*period_s, 0.25);
}

TEST(TrainBegin, ThreeCouldBeAnything) { EXPECT_FALSE(waiting_pulses({1000, 1250, 1500}).period_s()); }

TEST(TrainBegin, AnIntervalATenthOffIsOutOfStep) {
  EXPECT_TRUE(waiting_pulses({1000, 1250, 1520, 1750}).period_s());
  EXPECT_FALSE(waiting_pulses({1000, 1250, 1530, 1750}).period_s());
}

TEST(TrainBegin, TheStepsOfADriveThatIsNotLookedForAreNone) {
  EXPECT_FALSE(waiting_pulses({1000, 1200, 1400, 1600}).period_s()) << "5 Hz";
  EXPECT_FALSE(waiting_pulses({1000, 1500, 2000, 2500}).period_s()) << "2 Hz";
}

TEST(TrainBegin, AStrayPulseGoesOnceEnoughHaveFollowed) {
  TrainBegin begin = waiting_pulses({900, 1000, 1250, 1500});
  EXPECT_FALSE(begin.period_s());
  EXPECT_TRUE(begin.add(1'750'000'000)) << "the oldest goes";
  ASSERT_TRUE(begin.period_s());
  EXPECT_EQ(begin.pulses().front(), 1'000'000'000);
  EXPECT_EQ(begin.pulses().back(), 1'750'000'000);
}

TEST(TrainBegin, ClearedItWaitsForFourAnew) {
  TrainBegin begin = waiting_pulses({1000, 1250, 1500, 1750});
  begin.clear();
  EXPECT_TRUE(begin.pulses().empty());
  EXPECT_FALSE(begin.add(2'000'000'000));
  EXPECT_FALSE(begin.period_s());
}

}  // namespace
}  // namespace dwell
