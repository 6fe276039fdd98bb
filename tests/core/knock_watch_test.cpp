// A knock while the rig settles shows in the quarter of a period in which it comes.
#include "core/transient/knock_watch.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

constexpr double kQuarter_s = FreeMotion::kPeriodLength_s / kQuarters;

// Whether the last quarter of so many is an alarm: the fit goes on with the poles of the first four seconds.
bool alarm_in_last_of(int quarters, FreeMotion& motion, const FreeMotion::Beside& beside) {
  KnockWatch watch(2);
  motion.play(4);
  motion.learn_noise();
  motion.fit_all(0.2, std::vector<Complex>{FreeMotion::kMode});
  bool alarm = false;
  for (int i = 0; i < quarters; ++i) {
    const double from_s = motion.seconds;
    motion.play(kQuarter_s, beside);
    motion.fit.feed(motion.channels);
    motion.fit.solve(motion.channels);
    alarm = watch.sees_knock(motion.fit, motion.noise, motion.now(), to_ns(from_s));
  }
  return alarm;
}

TEST(KnockWatch, SeesAKnockInTheQuarterInWhichItComes) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    FreeMotion motion(seed);
    EXPECT_TRUE(alarm_in_last_of(1, motion, [](int c, double t) {
      return c == 1 ? 0.02 * (std::exp(FreeMotion::kMode * (t - 4)).imag()) : 0.0;
    })) << seed;
  }
}

TEST(KnockWatch, NoiseAloneIsNoAlarm) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    FreeMotion motion(seed);
    alarms += alarm_in_last_of(1, motion, FreeMotion::nothing);
  }
  EXPECT_EQ(alarms, 0);
}

TEST(KnockWatch, WhatShakesTheTableAloneIsTheDrivesAffair) {
  FreeMotion motion(1);
  motion.channels[1].imposed = true;
  EXPECT_FALSE(alarm_in_last_of(1, motion, [](int c, double) { return c == 1 ? 0.1 : 0.0; }));
}

TEST(KnockWatch, KeepsTheNewestAlarmUntilItIsClearedAndThatThereWasOneUntilTheNextHold) {
  KnockWatch watch(1);
  watch.begin_hold(100);
  EXPECT_EQ(watch.free_since_ns(), 100);
  EXPECT_FALSE(watch.alarm_ns());
  EXPECT_FALSE(watch.alarmed_since(INT64_MIN));
  watch.alarm(500);
  EXPECT_TRUE(watch.alarmed_since(499));
  EXPECT_FALSE(watch.alarmed_since(500));
  watch.set_free_since(500);
  watch.clear_alarm();
  EXPECT_FALSE(watch.alarm_ns());
  EXPECT_TRUE(watch.any());
  watch.begin_hold(900);
  EXPECT_FALSE(watch.any());
  EXPECT_EQ(watch.free_since_ns(), 900);
}

}  // namespace
}  // namespace dwell
