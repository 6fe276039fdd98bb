#include "daemon/estimate/channel_watch.hpp"

#include <gtest/gtest.h>

#include "tests/durations.hpp"

namespace dwell {
namespace {

TEST(ChannelWatch, IsStaleUntilTheFirstSample) {
  ChannelWatch watch(500.0, 0);
  EXPECT_EQ(watch.fault(), Fault::silent);
  EXPECT_FALSE(watch.reason().empty());
  EXPECT_TRUE(watch.sample(5 * kMs_ns, 6 * kMs_ns));
  EXPECT_EQ(watch.fault(), Fault::none);
  EXPECT_TRUE(watch.reason().empty());
  EXPECT_FALSE(watch.sample(7 * kMs_ns, 8 * kMs_ns)) << "the second one changes nothing";
}

TEST(ChannelWatch, FallsSilentAfterASecondEvenWhenFast) {
  ChannelWatch watch(500.0, 0);
  watch.sample(5 * kMs_ns, 6 * kMs_ns);
  EXPECT_FALSE(watch.fell_silent(1006 * kMs_ns));
  EXPECT_TRUE(watch.fell_silent(1007 * kMs_ns));
  EXPECT_EQ(watch.fault(), Fault::silent);
  EXPECT_FALSE(watch.fell_silent(1100 * kMs_ns)) << "said once";
  EXPECT_TRUE(watch.sample(1200 * kMs_ns, 1201 * kMs_ns)) << "and it recovers by itself";
}

TEST(ChannelWatch, GivesASlowChannelTwentyOfItsIntervals) {
  ChannelWatch watch(4.0, 0);
  watch.sample(1, 1);
  EXPECT_FALSE(watch.fell_silent(4900 * kMs_ns));
  EXPECT_TRUE(watch.fell_silent(5100 * kMs_ns));
}

TEST(ChannelWatch, IsMissingSinceItsNewestSampleHoweverLateTheFaultIsTold) {
  ChannelWatch watch(500.0, 0);
  EXPECT_EQ(watch.missing_since_ns(), 0) << "it has never delivered";
  watch.sample(5 * kMs_ns, 6 * kMs_ns);
  watch.said(20'000 * kMs_ns, Fault::timeout, "no answer within 0.1 s");
  watch.said(21'000 * kMs_ns, Fault::exception, "exception 2");
  EXPECT_EQ(watch.missing_since_ns(), 5 * kMs_ns);
}

TEST(ChannelWatch, ASampleOlderThanTheFaultIsNoProofOfRecovery) {
  ChannelWatch watch(500.0, 0);
  watch.sample(5 * kMs_ns, 6 * kMs_ns);
  EXPECT_TRUE(watch.said(50 * kMs_ns, Fault::timeout, "no answer within 0.1 s"));
  EXPECT_FALSE(watch.sample(49 * kMs_ns, 60 * kMs_ns));
  EXPECT_EQ(watch.fault(), Fault::timeout);
  EXPECT_EQ(watch.reason(), "no answer within 0.1 s");
  EXPECT_TRUE(watch.sample(70 * kMs_ns, 71 * kMs_ns));
}

TEST(ChannelWatch, KeepsTheDevicesOwnWordOverSilence) {
  ChannelWatch watch(500.0, 0);
  watch.said(1, Fault::disconnected, "connection refused");
  EXPECT_FALSE(watch.fell_silent(3600'000 * kMs_ns));
  EXPECT_EQ(watch.fault(), Fault::disconnected);
}

TEST(ChannelWatch, SayingTheSameAgainIsNoNews) {
  ChannelWatch watch(500.0, 0);
  EXPECT_TRUE(watch.said(1, Fault::timeout, nullptr));
  EXPECT_EQ(watch.reason(), "timeout") << "a fault always has words";
  EXPECT_FALSE(watch.said(2, Fault::timeout, "again"));
  EXPECT_EQ(watch.since_ns(), 1);
}

TEST(ChannelWatch, MeasuresTheRateOfWhatArrives) {
  ChannelWatch watch(500.0, 0);
  for (std::int64_t i = 1; i <= 750; ++i) watch.sample(i * 2 * kMs_ns, i * 2 * kMs_ns);
  watch.measure_rate(1500 * kMs_ns);
  EXPECT_DOUBLE_EQ(watch.rate_hz(), 500.0);
  watch.measure_rate(2600 * kMs_ns);
  EXPECT_DOUBLE_EQ(watch.rate_hz(), 0.0);
}

}  // namespace
}  // namespace dwell
