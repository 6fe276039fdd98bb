// When the natural oscillations are fitted anew.
#include "core/transient/refit_schedule.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(RefitSchedule, OfANewHoldTheFirstRefitIsDueAtOnceAndNoneHasBeenMade) {
  RefitSchedule schedule;
  EXPECT_TRUE(schedule.due(INT64_MIN + 1));
  EXPECT_FALSE(schedule.made_ns());
  schedule.made(3);
  schedule.plan_no_more();
  schedule.begin_hold();
  EXPECT_TRUE(schedule.due(0));
  EXPECT_FALSE(schedule.made_ns());
}

TEST(RefitSchedule, GrowsWithTheFreeMotion) {
  RefitSchedule schedule;
  schedule.plan_growth(1.25, 2 * kSecond, 10 * kSecond);
  EXPECT_EQ(schedule.planned_ns(), 12 * kSecond);
  EXPECT_FALSE(schedule.due(12 * kSecond - 1));
  EXPECT_TRUE(schedule.due(12 * kSecond));
}

TEST(RefitSchedule, AnEarlierWishBringsARefitForwardAndALaterOneDoesNotPutItOff) {
  RefitSchedule schedule;
  schedule.plan_no_later_than(5);
  EXPECT_TRUE(schedule.due(1)) << "at once is sooner than any instant";
  schedule.plan(20);
  schedule.plan_no_later_than(30);
  EXPECT_EQ(schedule.planned_ns(), 20);
  schedule.plan_no_later_than(10);
  EXPECT_EQ(schedule.planned_ns(), 10);
}

TEST(RefitSchedule, NeverLastsUntilARefitIsAskedFor) {
  RefitSchedule schedule;
  schedule.plan_no_more();
  EXPECT_FALSE(schedule.due(INT64_MAX));
  schedule.plan_no_later_than(7);
  EXPECT_FALSE(schedule.due(6));
  EXPECT_TRUE(schedule.due(7));
}

TEST(RefitSchedule, BelievesAtOnceWhatNoRoundingHidesAndWhatComesBySteps) {
  RefitSchedule schedule;
  EXPECT_TRUE(schedule.believes({.left = 0.9, .left_before = 5.0, .rounded = false}, 0.2, 0, 10 * kSecond));
  EXPECT_TRUE(schedule.believes({.left = 0.9, .left_before = 1.1, .rounded = true}, 0.2, 0, 10 * kSecond));
  EXPECT_FALSE(schedule.believes({.left = 1.1, .left_before = 1.2, .rounded = false}, 0.2, 0, 10 * kSecond));
  EXPECT_FALSE(schedule.confirm_ns());
}

TEST(RefitSchedule, ASuddenClaimOfRoundedReadingsIsBelievedOnlyWhenItHoldsATwentiethOfTheHoldLater) {
  RefitSchedule schedule;
  const RefitSchedule::Claim sudden{.left = 0.9, .left_before = 5.0, .rounded = true};
  EXPECT_FALSE(schedule.believes(sudden, 0.2, 0, 20 * kSecond));
  ASSERT_TRUE(schedule.confirm_ns());
  EXPECT_EQ(*schedule.confirm_ns(), 21 * kSecond);
  EXPECT_EQ(schedule.planned_ns(), 21 * kSecond);
  const RefitSchedule::Claim again{.left = 0.9, .left_before = 0.9, .rounded = true};
  EXPECT_FALSE(schedule.believes(again, 0.2, 0, 20 * kSecond + 1));
  EXPECT_TRUE(schedule.believes(again, 0.2, 0, 21 * kSecond));
}

TEST(RefitSchedule, AClaimThatDoesNotHoldIsForgotten) {
  RefitSchedule schedule;
  EXPECT_FALSE(schedule.believes({.left = 0.9, .left_before = 5.0, .rounded = true}, 0.2, 0, 2 * kSecond));
  EXPECT_EQ(*schedule.confirm_ns(), 2 * kSecond + 400'000'000) << "two periods at least";
  EXPECT_FALSE(schedule.believes({.left = 1.5, .left_before = 0.9, .rounded = true}, 0.2, 0, 3 * kSecond));
  EXPECT_FALSE(schedule.confirm_ns());
}

}  // namespace
}  // namespace dwell
