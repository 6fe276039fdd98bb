// What becomes of a dwell that has ended: told, once its reason is known, or passed over.
#include "core/dwell/finished_dwell.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

constexpr double kFourHertz = 4 * kTwoPi;
constexpr std::int64_t kFivePeriods_ns = 1'250'000'000;

Dwell dwell_settled_at(double settled_s) {
  Dwell dwell;
  dwell.state = State::measuring;
  dwell.settled_s = settled_s;
  return dwell;
}

TEST(FinishedDwell, OneThatSettledIsToldHoweverShort) {
  FinishedDwell finished;
  finished.keep(dwell_settled_at(0.5), 0, kFourHertz);
  EXPECT_TRUE(finished.conclude(EndedBy::drive_changed, 1));
  EXPECT_EQ(finished.dwell().ended_by, EndedBy::drive_changed);
  EXPECT_EQ(finished.dwell().state, State::complete);
  EXPECT_TRUE(std::isnan(finished.dwell().settles_in_s));
}

TEST(FinishedDwell, OneThatNeverSettledIsToldOnlyAfterFivePeriods) {
  FinishedDwell finished;
  finished.keep(dwell_settled_at(kNaN), 1000, kFourHertz);
  EXPECT_FALSE(finished.conclude(EndedBy::drive_stopped, 1000 + kFivePeriods_ns - 1000));
  EXPECT_TRUE(finished.conclude(EndedBy::drive_stopped, 1000 + kFivePeriods_ns + 1000));
}

TEST(FinishedDwell, TheEndOfTheRunTellsEvenOneHardlyBegun) {
  FinishedDwell finished;
  finished.keep(dwell_settled_at(kNaN), 0, kFourHertz);
  EXPECT_TRUE(finished.conclude(EndedBy::end, 1));
}

TEST(FinishedDwell, ItsReasonIsWaitedForNoLongerThan64Periods) {
  FinishedDwell finished;
  finished.keep(dwell_settled_at(1.0), 0, kFourHertz);
  finished.wait_for_reason(100);
  EXPECT_FALSE(finished.waited_enough(355));
  EXPECT_TRUE(finished.waited_enough(356));
}

}  // namespace
}  // namespace dwell
