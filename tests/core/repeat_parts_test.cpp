// What tells a held register from repeated answers, part by part; and what the motion gate knows of answers and errors.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/chance.hpp"
#include "core/intake/answer_lateness.hpp"
#include "core/intake/prediction_errors.hpp"
#include "core/intake/repeat_catch_up.hpp"
#include "core/intake/repeat_counts.hpp"
#include "core/intake/repeat_distances.hpp"
#include "core/intake/waiting_readings.hpp"

namespace dwell {
namespace {

TEST(RepeatCounts, AFineMotionHasNoRepeatsByChanceAndInterruptionsSoonShow) {
  RepeatCounts counts;
  for (int i = 0; i < 100; ++i) {
    counts.next();
    counts.differs(i < 3 ? 1e-6 : 1.0);
  }
  EXPECT_TRUE(counts.step_known());
  EXPECT_LT(counts.by_chance(), 1e-3);
  for (int i = 0; i < 20 && !counts.interrupts_beyond_chance(); ++i) {
    counts.next();
    counts.repeats_one_before();
    counts.interrupted(2);
  }
  EXPECT_TRUE(counts.interrupts_beyond_chance());
  EXPECT_LE(counts.interruptions(), 20);
  EXPECT_TRUE(counts.few());
  EXPECT_FALSE(counts.many());
}

TEST(RepeatCounts, AChannelThatStuckOnceInterruptsTheMotionByOneReading) {
  RepeatCounts counts;
  for (int i = 0; i < 10; ++i) counts.next(), counts.differs(1.0);
  counts.interrupted(1000);
  EXPECT_TRUE(counts.interrupts());
  for (int i = 0; i < 5000; ++i) counts.next(), counts.differs(1.0);
  EXPECT_TRUE(counts.hardly_interrupts());
}

TEST(RepeatDistances, EvenDistancesProveARegisterAndRandomOnesRefuteIt) {
  RepeatDistances even, uneven;
  std::mt19937 random(1);
  std::geometric_distribution<int> geometric(1.0 / 50);
  for (int i = 0; i < 40; ++i) {
    even.pass(static_cast<std::size_t>(50 + i % 3));
    even.repeat(false);
    uneven.pass(static_cast<std::size_t>(2 + geometric(random)));
    uneven.repeat(false);
  }
  EXPECT_GE(even.proof(), nats::kOneIn1000);
  EXPECT_FALSE(even.irregular());
  EXPECT_LT(uneven.proof(), 0.0);
  EXPECT_TRUE(uneven.irregular());
}

TEST(RepeatDistances, ARunTooLongForARegisterSpeaksAgainstIt) {
  RepeatDistances distances;
  distances.repeat(true);
  EXPECT_EQ(distances.proof(), RepeatDistances::kIrregular);
}

TEST(RepeatCatchUp, AJumpAsLongAsTheRunIsOfARepeatedAnswer) {
  RepeatCatchUp answers, held;
  for (int i = 0; i < 3; ++i) answers.add(2, 1.0, 2.0, 1.0, 1.0), held.add(2, 1.0, 1.0, 1.0, 0.5);
  EXPECT_FALSE(answers.shown()) << "three are too few";
  EXPECT_TRUE(held.possible());
  answers.add(2, 1.0, 2.0, 1.0, 1.0);
  held.add(2, 1.0, 1.0, 1.0, 0.5);
  EXPECT_TRUE(answers.shown());
  EXPECT_FALSE(held.shown() || held.possible());
  RepeatCatchUp slow;
  for (int i = 0; i < 10; ++i) slow.add(2, 0.1, 0.2, 0.1, 1.0);
  EXPECT_FALSE(slow.shown()) << "noise has a sign as well";
}

TEST(AnswerLateness, TheUsualAnswerIsLearntAndAFarLateOneIsRareOnlyWhileFewAre) {
  AnswerLateness lateness;
  for (int i = 0; i < 200; ++i) lateness.see(i % 20 == 0 ? 10'000.0 : 1000.0, i < 40);
  EXPECT_FALSE(lateness.held_up(1000.0));
  EXPECT_TRUE(lateness.held_up(2000.0));
  EXPECT_FALSE(lateness.by_far(2000.0));
  EXPECT_TRUE(lateness.by_far(10'000.0));
  EXPECT_TRUE(lateness.rare());
  for (int i = 0; i < 400; ++i) lateness.see(i % 3 == 0 ? 10'000.0 : 1000.0, false);
  EXPECT_FALSE(lateness.rare());
}

TEST(PredictionErrors, TheNoiseIsKnownFromFortyErrorsOnAndAJumpWidensItAtOnce) {
  PredictionErrors errors;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int learnt = 0;
  for (; !errors.known(); ++learnt) {
    EXPECT_EQ(errors.noise(), 0.0);
    errors.learn(std::abs(normal(random)));
  }
  EXPECT_EQ(learnt, 41);
  for (int i = 0; i < 2000; ++i) errors.add(std::abs(normal(random)));
  EXPECT_NEAR(errors.noise(), 1.0, 0.2);
  errors.jump(600.0);
  EXPECT_EQ(errors.median(), 100.0);
}

TEST(WaitingReadings, GoOnEvenlyOnALineAndAreHandedOutOnce) {
  WaitingReadings waiting;
  waiting.add({1, 10.0});
  waiting.add({2, 11.0});
  EXPECT_TRUE(waiting.goes_on_evenly({3, 12.0}, 0.0));
  EXPECT_FALSE(waiting.goes_on_evenly({3, 8.0}, 0.0));
  EXPECT_TRUE(waiting.goes_on_evenly({3, 8.0}, 4.0)) << "within the gate's limit";
  const auto taken = waiting.take();
  ASSERT_EQ(taken.size(), 2u);
  EXPECT_EQ(taken[1].value, 11.0);
  EXPECT_EQ(waiting.count(), 0u);
}

}  // namespace
}  // namespace dwell
