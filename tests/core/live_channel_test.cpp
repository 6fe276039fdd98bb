// A channel as it delivers: what is counted, when it is lost, when it is stuck, and which one shows the drive.
#include "core/intake/live_channel.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/intake/live_channels.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kLivePeriod_s = 0.25;
constexpr std::int64_t kLiveStep_ns = 5'000'000;

Record reading_at(std::int64_t t_ns, double value, std::uint16_t channel = 0) {
  Record record;
  record.t_ns = t_ns;
  record.value = value;
  record.channel = channel;
  return record;
}

// Hears and judges one sample; how many readings count by it.
int hear(LiveChannel& channel, const Record& record) {
  if (!channel.hear(record)) return 0;
  int counted = 0;
  channel.judge(record, 2 * M_PI / kLivePeriod_s, [&](const LiveChannel::Reading& passed) {
    channel.count(passed);
    ++counted;
  });
  return counted;
}

TEST(LiveChannel, DeliversUntilItsNewestSampleIsOlderThanASecondAndTwoPeriods) {
  LiveChannel channel{Channel{}};
  EXPECT_FALSE(channel.delivers(0, kLivePeriod_s)) << "nothing has come yet";
  EXPECT_EQ(channel.silent_reason(), "no sample yet");
  hear(channel, reading_at(0, 1.0));
  EXPECT_TRUE(channel.delivers(999'000'000, kLivePeriod_s));
  EXPECT_FALSE(channel.delivers(1'001'000'000, kLivePeriod_s));
  EXPECT_TRUE(channel.delivers(1'001'000'000, 1.0)) << "two periods of a slow drive are longer than a second";
}

TEST(LiveChannel, AFaultThatIsToldEndsDeliveryAtOnceAndTheNextSampleBeginsItAgain) {
  LiveChannel channel{Channel{}};
  hear(channel, reading_at(0, 1.0));
  channel.tell(Fault::timeout);
  EXPECT_FALSE(channel.delivers(1, kLivePeriod_s));
  EXPECT_EQ(channel.silent_reason(), "stale, timeout");
  hear(channel, reading_at(2, 1.1));
  EXPECT_TRUE(channel.delivers(3, kLivePeriod_s));
}

TEST(LiveChannel, WhatIsNotAfterTheSampleBeforeOrNotFiniteIsCountedAsRejected) {
  LiveChannel channel{Channel{}};
  hear(channel, reading_at(10, 1.0));
  EXPECT_EQ(hear(channel, reading_at(10, 2.0)), 0);
  EXPECT_EQ(hear(channel, reading_at(20, NAN)), 0);
  channel.refuse();
  EXPECT_EQ(channel.now(kLivePeriod_s).rejected, 3u);
  EXPECT_EQ(channel.now(kLivePeriod_s).used, 1u);
  EXPECT_EQ(channel.value(), 1.0);
}

TEST(LiveChannel, OneReadingForLongerThanTwoPeriodsIsStuckUntilItChanges) {
  LiveChannel channel{Channel{}};
  std::int64_t t_ns = 0;
  for (; t_ns <= 490'000'000; t_ns += kLiveStep_ns) hear(channel, reading_at(t_ns, 1.0));
  EXPECT_FALSE(channel.stuck(kLivePeriod_s));
  for (; t_ns <= 520'000'000; t_ns += kLiveStep_ns) hear(channel, reading_at(t_ns, 1.0));
  EXPECT_TRUE(channel.stuck(kLivePeriod_s));
  EXPECT_TRUE(channel.unfit(kLivePeriod_s, 0.005));
  EXPECT_EQ(channel.now(kLivePeriod_s).condition, Condition::stuck);
  EXPECT_NE(channel.condition_reason(kLivePeriod_s).find("stuck at one reading for 0.52"), std::string::npos)
      << channel.condition_reason(kLivePeriod_s);
  hear(channel, reading_at(t_ns, 1.5));
  EXPECT_FALSE(channel.stuck(kLivePeriod_s));
}

// A service that was held up read one value before the pause and the same after it, and the dwell ended.
TEST(LiveChannel, APauseBetweenTwoEqualReadingsIsNotStuck) {
  LiveChannel channel{Channel{}};
  std::int64_t t_ns = 0;
  for (int i = 0; i < 1000; ++i, t_ns += kLiveStep_ns) hear(channel, reading_at(t_ns, i % 7));
  hear(channel, reading_at(t_ns, 1.0));
  hear(channel, reading_at(t_ns + 3'000'000'000, 1.0));
  EXPECT_FALSE(channel.stuck(kLivePeriod_s));
}

TEST(LiveChannel, AReadingIsLateBeyondOneAndAHalfTimesTheUsualTurnaroundOfThisHold) {
  LiveChannel channel{Channel{}};
  for (int i = 0; i < 10; ++i) channel.count({i * kLiveStep_ns, 0.0, 1'000'000});
  EXPECT_EQ(channel.extra_u_s({0, 0.0, 1'400'000}), 0.0);
  EXPECT_NEAR(channel.extra_u_s({0, 0.0, 4'500'000}), 3e-3, 1e-9);
  EXPECT_NEAR(channel.turnaround_u_s(), 1e-3 / std::sqrt(3.0), 1e-12);
  channel.begin_hold();
  EXPECT_EQ(channel.turnaround_u_s(), 0.0) << "of a hold that has no reading yet";
}

Rig table_twice() {
  Rig rig;
  for (const char* name : {"force", "y1", "table", "second"}) {
    Channel channel;
    channel.name = name;
    channel.measures = std::string(name) == "force" ? Quantity::force : Quantity::displacement;
    channel.at = std::string(name) == "y1" ? 1 : 0;
    rig.channels.push_back(channel);
  }
  return rig;
}

TEST(LiveChannels, TheFirstTransducerOfTheTableShowsTheDrive) {
  const Rig rig = table_twice();
  const LiveChannels channels(rig);
  EXPECT_EQ(channels.drive(), 2);
  EXPECT_EQ(channels.on_table(), (std::vector<char>{0, 0, 1, 1}));
}

TEST(LiveChannels, WithoutATransducerOnTheTableTheFirstThatSeesMotionShowsTheDrive) {
  Rig rig = table_twice();
  rig.channels.resize(2);
  EXPECT_EQ(LiveChannels(rig).drive(), 1);
}

TEST(LiveChannels, WhereTheDrivesChannelIsLostAnotherOfTheTableThatDeliversTakesItsPlace) {
  const Rig rig = table_twice();
  LiveChannels channels(rig);
  channels.choose_drive(0, kLivePeriod_s);
  EXPECT_EQ(channels.drive(), 2) << "none delivers: it stays";
  int counted = 0;
  channels.sample(reading_at(0, 1.0, 3), 2 * M_PI / kLivePeriod_s,
                  [&](LiveChannel&, const LiveChannel::Reading&) { ++counted; });
  channels.choose_drive(1, kLivePeriod_s);
  EXPECT_EQ(channels.drive(), 3);
}

}  // namespace
}  // namespace dwell
