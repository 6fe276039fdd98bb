// A hold fitted anew, by poles from wherever they can be had.
#include "core/transient/hold_refit.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

constexpr SeenFrequency kSeen{FreeMotion::kDrive, 0.0, 0};

double off_true_mode(SearchedMotion& motion) {
  const auto& beside = motion.search.poles().beside;
  return std::abs(motion.search.poles().chain.at(0) - FreeMotion::kMode) / motion.fit.fit().u_pole(beside.size());
}

TEST(HoldRefit, IsNotPossibleWithoutAnyPoles) {
  SearchedMotion motion(1, {});
  motion.play(4);
  EXPECT_FALSE(motion.refit.possible());
  EXPECT_FALSE(motion.refit.make(kSeen, motion.now()));
}

TEST(HoldRefit, BeginsWithTheChainsPolesAndBelievesTheDatas) {
  SearchedMotion motion(2, {{-0.7, 34.0}});
  motion.play(6);
  motion.learn_noise();
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_TRUE(motion.explained());
  EXPECT_LT(off_true_mode(motion), 4.0);
  EXPECT_TRUE(motion.search.poles().beside.empty());
}

TEST(HoldRefit, LeavesOutTheFirstPeriodThenTheBeginningOfTheHold) {
  SearchedMotion motion(3, {FreeMotion::kMode});
  motion.play(6);
  motion.learn_noise();
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_EQ(motion.fit.from_ns(), to_ns(kUnsure * FreeMotion::kPeriodLength_s));
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_EQ(motion.fit.from_ns(), to_ns(0.15 * 6));
  motion.refit.begin_hold();
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_EQ(motion.fit.from_ns(), to_ns(kUnsure * FreeMotion::kPeriodLength_s));
}

TEST(HoldRefit, WhatNoPolesExplainIsShedFurther) {
  SearchedMotion motion(4, {FreeMotion::kMode});
  // Something that is no oscillation, in ever other form.
  motion.play(8, [](int c, double t) { return c == 1 ? 0.1 * std::sin(60 * t * t) : 0.0; });
  motion.learn_noise();
  std::int64_t before_ns = 0;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
    EXPECT_FALSE(motion.explained());
    EXPECT_GT(motion.fit.from_ns(), before_ns);
    before_ns = motion.fit.from_ns();
  }
}

TEST(HoldRefit, GivesHumAPoleOfItsOwn) {
  SearchedMotion motion(5, {FreeMotion::kMode});
  motion.play(6, [](int c, double t) { return c == 1 ? 0.01 * std::sin(kTwoPi * 50.0 * t) : 0.0; });
  motion.learn_noise();
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_TRUE(motion.explained());
  EXPECT_TRUE(motion.search.poles().hums());
  EXPECT_LT(off_true_mode(motion), 4.0);
}

TEST(HoldRefit, AfterAKnockFitsTheMotionSince) {
  SearchedMotion motion(6, {FreeMotion::kMode});
  const auto knock = [](int c, double t) {
    return t < 4.0 ? 0.0 : 0.2 * (c + 1) * std::exp(FreeMotion::kMode * (t - 4.0)).imag();
  };
  motion.play(4, knock);
  motion.learn_noise();
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  motion.play(2, knock);
  motion.knocks.alarm(to_ns(4.0));
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_TRUE(motion.explained());
  EXPECT_GE(motion.knocks.free_since_ns(), to_ns(4.0));
  EXPECT_EQ(motion.fit.fit().t0_ns(), motion.knocks.free_since_ns());
  EXPECT_TRUE(motion.search.poles().beside.empty()) << "a knock within the fit looks like a line";
}

TEST(HoldRefit, AFalseAlarmChangesNothing) {
  SearchedMotion motion(7, {FreeMotion::kMode});
  motion.play(6);
  motion.learn_noise();
  motion.knocks.alarm(to_ns(4.0));
  ASSERT_TRUE(motion.refit.make(kSeen, motion.now()));
  EXPECT_TRUE(motion.explained());
  EXPECT_EQ(motion.knocks.free_since_ns(), 0);
}

TEST(HoldRefit, FollowsADriveThatDrifts) {
  const double rate = 1e-3 * FreeMotion::kDrive;  // rad/s²
  SearchedMotion motion(8, {FreeMotion::kMode});
  motion.play(6, [&](int c, double t) {
    const double steady = FreeMotion::kDrive * t + c;
    return std::sin(steady + 0.5 * rate * t * t) - std::sin(steady);
  });
  motion.learn_noise();
  ASSERT_TRUE(motion.refit.make({FreeMotion::kDrive, rate, 0}, motion.now()));
  EXPECT_TRUE(motion.explained());
  EXPECT_EQ(motion.fit.fit().rate(), rate);
}

}  // namespace
}  // namespace dwell
