// Work in slices: it pauses where it has spent what it was allowed, and goes on there.
#include "core/base/slices.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

// Ten pieces of work of 3 each.
struct Work {
  int done = 0;
  Slices slices{[this] {
    for (int i = 0; i < 10; ++i) {
      ++done;
      slices.spend(3);
    }
  }};
};

TEST(Slices, WorkPausesWhereItHasSpentWhatItWasAllowedAndGoesOnThere) {
  Work work;
  work.slices.allow(7, 100);
  EXPECT_FALSE(work.slices.begin());
  EXPECT_TRUE(work.slices.busy());
  EXPECT_EQ(work.done, 3) << "it pauses after the piece that exceeds 7";
  EXPECT_FALSE(work.slices.may_work());
  work.slices.allow(14, 100);
  EXPECT_FALSE(work.slices.go_on());
  EXPECT_EQ(work.done, 8) << "24 are more than the 21 allowed in all";
  work.slices.allow_all();
  EXPECT_TRUE(work.slices.go_on());
  EXPECT_EQ(work.done, 10);
  EXPECT_FALSE(work.slices.busy());
}

TEST(Slices, NeverIsMoreAllowedAtOnceThanTheMost) {
  Work work;
  for (int i = 0; i < 100; ++i) work.slices.allow(5, 10);
  EXPECT_FALSE(work.slices.begin());
  EXPECT_EQ(work.done, 4);
}

TEST(Slices, WorkMayBeginAgainAndAgain) {
  Work work;
  work.slices.allow_all();
  for (int i = 1; i <= 5; ++i) {
    EXPECT_TRUE(work.slices.begin());
    EXPECT_EQ(work.done, 10 * i);
  }
}

TEST(Slices, WhatIsNotDoneAtTheEndIsDoneThen) {
  int done = 0;
  {
    Slices* within = nullptr;
    Slices slices([&] {
      within->spend(1);
      done = 1;
    });
    within = &slices;
    slices.allow(0.5, 1);
    slices.begin();
    EXPECT_EQ(done, 0);
  }
  EXPECT_EQ(done, 1);
}

TEST(Slices, OutsideOfTheWorkNothingIsSpent) {
  Work work;
  work.slices.allow(1, 1);
  work.slices.spend(1000);
  EXPECT_TRUE(work.slices.may_work());
}

}  // namespace
}  // namespace dwell
