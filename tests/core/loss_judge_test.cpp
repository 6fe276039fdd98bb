#include "core/stream/loss_judge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <random>

namespace dwell {
namespace {

// A judge that has learnt a uniform jitter of so many periods, and the arrivals that wait for its verdict.
class WaitingArrivals {
 public:
  explicit WaitingArrivals(double jitter) {
    ArrivalGrid grid;
    grid.period_ns = 1e6;
    grid.last_ns = 63e6;
    grid.spread = jitter / 4;
    std::mt19937_64 rng(1);
    std::uniform_real_distribution<double> uniform(-jitter / 2, jitter / 2);
    for (int i = 0; i < 512; ++i) grid.shape.add(uniform(rng));
    clock.begin(grid, 0, 64, 0.0);
    judge.begin(grid, 63'000'000);
  }
  // Arrivals at so many periods after the newest reading.
  WaitingArrivals& arrive(std::initializer_list<double> periods) {
    for (const double at : periods) held.add(63'000'000 + std::llround(1e6 * at));
    return *this;
  }
  [[nodiscard]] LossJudge::Verdict now(bool at_once = false) const { return judge.judge(held, clock, at_once); }

  HeldArrivals held;
  ClockTracker clock;
  LossJudge judge;
};

TEST(LossJudge, ReadingsOnTimeAreDecidedAtOnce) {
  WaitingArrivals waiting(0.4);
  const LossJudge::Verdict verdict = waiting.arrive({1.0, 2.1, 2.9}).now();
  EXPECT_EQ(verdict.settled, 3u);
  EXPECT_EQ(verdict.lost, 0);
}

TEST(LossJudge, AReadingOnePeriodLateWaitsForMoreEvidence) {
  WaitingArrivals waiting(0.4);
  EXPECT_EQ(waiting.arrive({1.0, 3.0}).now().settled, 1u);
  EXPECT_EQ(waiting.now().lost, 0);
}

TEST(LossJudge, ReadingsThatKeepBeingLateFollowALoss) {
  for (const int lost : {1, 2, 3}) {
    WaitingArrivals waiting(0.4);
    waiting.arrive({1.0, 2.0});
    for (int i = 3; i <= 12; ++i) waiting.arrive({1.0 * (i + lost)});
    const LossJudge::Verdict verdict = waiting.now();
    EXPECT_EQ(verdict.lost, lost);
    EXPECT_EQ(verdict.settled, 2u);
  }
}

TEST(LossJudge, AnEarlierOneAfterwardsShowsThatNothingWasLost) {
  WaitingArrivals waiting(0.4);
  const LossJudge::Verdict verdict = waiting.arrive({1.0, 3.0, 3.2, 4.0, 5.0}).now();
  EXPECT_EQ(verdict.lost, 0);
  EXPECT_EQ(verdict.settled, 5u);
}

TEST(LossJudge, ABunchWasHeldUpAndNotLost) {
  WaitingArrivals waiting(0.4);
  for (int i = 0; i < 40; ++i) waiting.arrive({40.0 + 0.001 * i});
  EXPECT_EQ(waiting.now().lost, 0);
  // The 40th of the bunch is on time.
  EXPECT_EQ(waiting.now().settled, 40u);
}

TEST(LossJudge, OneMuchTooEarlyTakesBackWhatWasCountedTooMany) {
  WaitingArrivals waiting(0.4);
  const LossJudge::Verdict verdict = waiting.arrive({-3.0}).now();
  EXPECT_EQ(verdict.settled, 0u);
  EXPECT_EQ(verdict.lost, -4);
}

TEST(LossJudge, AtOnceAllThatWaitIsDecided) {
  WaitingArrivals waiting(0.4);
  waiting.arrive({2.0});
  EXPECT_EQ(waiting.now().settled, 0u);
  const LossJudge::Verdict verdict = waiting.now(true);
  EXPECT_TRUE(verdict.settled == 1 || verdict.lost == 1);
}

TEST(LossJudge, LossAfterLossIsImplausible) {
  WaitingArrivals waiting(0.4);
  int losses = 0;
  for (; losses < 200 && !waiting.judge.implausible(); ++losses) waiting.judge.count(1);
  EXPECT_EQ(losses, 77) << "each is one of 256 readings; 0.3 of them is too much";
}

TEST(LossJudge, NumbersTakenBackBeyondTheLossesAreImplausible) {
  WaitingArrivals waiting(0.4);
  waiting.judge.count(-4);
  waiting.judge.count(2);
  waiting.judge.count(-4);
  EXPECT_FALSE(waiting.judge.implausible());
  waiting.judge.count(-3);
  EXPECT_TRUE(waiting.judge.implausible());
}

}  // namespace
}  // namespace dwell
