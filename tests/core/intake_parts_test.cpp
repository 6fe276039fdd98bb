// The small owners that the intake of a channel is made of, each by itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/intake/device_numbers.hpp"
#include "core/intake/end_codes.hpp"
#include "core/intake/even_runs.hpp"
#include "core/intake/foreign_readings.hpp"
#include "core/intake/left_out.hpp"
#include "core/intake/motion_predictor.hpp"
#include "core/intake/reading_times.hpp"
#include "core/intake/recent_numbers.hpp"
#include "core/intake/recurring_numbers.hpp"
#include "core/intake/refresh_stamps.hpp"
#include "core/intake/repeat_beat.hpp"
#include "core/intake/repeated_answers.hpp"

namespace dwell {
namespace {

TEST(RecentNumbers, TheOldestIsForgotten) {
  RecentNumbers<3> recent;
  EXPECT_FALSE(recent.has(0.0));
  EXPECT_TRUE(std::isnan(recent.newest()));
  for (const double number : {1.0, 2.0, 3.0, 4.0}) recent.add(number);
  EXPECT_FALSE(recent.has(1.0));
  EXPECT_TRUE(recent.has(2.0));
  EXPECT_EQ(recent.newest(), 4.0);
}

TEST(DeviceNumbers, AReadingInMillimetresOfATransducerThatCountsBackwards) {
  Channel channel;
  channel.unit = "mm";
  channel.si_per_unit = 1e-3;
  channel.scale = -0.01;
  channel.offset = 5.0;
  channel.range.low = -1.0;
  channel.range.high = 4.0;
  const DeviceNumbers numbers(channel);
  EXPECT_DOUBLE_EQ(numbers.si(100.0), 4e-3);
  EXPECT_DOUBLE_EQ(numbers.si_of_difference(2.0), 2e-5);
  EXPECT_DOUBLE_EQ(numbers.difference_of_si(2e-5), 2.0);
  EXPECT_EQ(numbers.text(200.0), "3 mm");
  EXPECT_TRUE(numbers.beyond_range(99.0));
  EXPECT_FALSE(numbers.beyond_range(101.0));
  EXPECT_TRUE(numbers.beyond_range(601.0));
}

TEST(EndCodes, ANumberIsOneOnlyWhileNothingLiesBeyondIt) {
  EndCodes codes;
  codes.see(-12.0);
  codes.see(31000.0);
  EXPECT_TRUE(codes.has(32767.0));
  EXPECT_TRUE(codes.has(-32768.0));
  EXPECT_FALSE(codes.has(32766.0));
  EXPECT_EQ(codes.largest(), 31000.0);
  codes.see(40000.0);
  EXPECT_FALSE(codes.has(32767.0));
  EXPECT_TRUE(codes.has(65535.0));
}

TEST(ReadingTimes, TheIntervalIsTheMeanAndANewHoldCountsAnew) {
  ReadingTimes times;
  EXPECT_FALSE(times.heard());
  EXPECT_TRUE(std::isnan(times.add(1'000'000'000, 5.0)));
  EXPECT_EQ(times.interval_s(), 0.0);
  EXPECT_EQ(times.add(1'010'000'000, 7.0), 5.0);
  times.add(1'030'000'000, 7.0);
  EXPECT_DOUBLE_EQ(times.interval_s(), 0.015);
  EXPECT_DOUBLE_EQ(times.same_for_s(), 0.02);
  times.restart();
  EXPECT_EQ(times.count(), 0u);
  times.add(2'000'000'000, 7.0);
  EXPECT_DOUBLE_EQ(times.same_for_s(), 0.99);
}

TEST(LeftOut, AFewThatTheGateTakesOfGoodReadingsDoNotMatter) {
  LeftOut left;
  left.begin_to_count(0, 0);
  EXPECT_FALSE(left.matters(10'000, 5, false));  // 0.05 √10 000
  EXPECT_TRUE(left.matters(10'000, 6, false));
  for (int i = 0; i < 6; ++i) left.repeat();
  EXPECT_TRUE(left.matters(10'000, 0, false));
  EXPECT_FALSE(left.matters(10'000, 0, true));
}

TEST(LeftOut, WhatWasLeftOutWhileTheTransientWasLargeIsSaidNoMore) {
  LeftOut left;
  left.spike();
  left.far_spike();
  EXPECT_TRUE(left.matters(100, 40, false));
  left.begin_to_count(100, 40);
  EXPECT_FALSE(left.matters(200, 40, false));
  left.beyond_range(true);
  EXPECT_TRUE(left.matters(200, 40, false));
  EXPECT_EQ(left.codes(), 1u);
  left.begin_hold();
  EXPECT_EQ(left.overrange(), 0u);
  EXPECT_EQ(left.of_all_time(), 2u);
}

TEST(ForeignReadings, TheCommonestIsFoundAmongOthers) {
  ForeignReadings foreign;
  for (int i = 0; i < 20; ++i) {
    foreign.add(0.0, i > 0);
    if (i % 3 == 0) foreign.add(100.0 + i, false);
  }
  EXPECT_EQ(foreign.all(), 27u);
  EXPECT_EQ(foreign.repeats(), 19u);
  EXPECT_TRUE(foreign.cluster());
  EXPECT_EQ(foreign.value(), 0.0);
  foreign.restart();
  EXPECT_EQ(foreign.all(), 0u);
  EXPECT_EQ(foreign.of_all_time(), 27u);
  EXPECT_EQ(foreign.value(), 0.0);
}

TEST(MotionPredictor, ASineAtTheDrivesFrequencyIsPredictedExactly) {
  const double omega = 30.0;
  const auto at = [&](std::int64_t t_ns) { return 2.0 + 3 * std::sin(1e-9 * omega * static_cast<double>(t_ns) + 0.4); };
  MotionPredictor predictor;
  std::int64_t t_ns = 0;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(predictor.predict(t_ns, t_ns, omega).gain, 0.0) << i << " readings are too few";
    predictor.add(t_ns, at(t_ns));
    t_ns += 4'000'000 + 500'000 * (i % 3);
  }
  const MotionPredictor::Prediction next = predictor.predict(t_ns, t_ns - 4'000'000, omega);
  EXPECT_GT(next.gain, 1.0);
  EXPECT_NEAR(next.value, at(t_ns), 1e-9);
  // After a pause, or with fewer than five readings a period, nothing is.
  EXPECT_EQ(predictor.predict(t_ns, t_ns - 40'000'000, omega).gain, 0.0);
  EXPECT_EQ(predictor.predict(t_ns, t_ns - 4'000'000, 20 * omega).gain, 0.0);
}

TEST(MotionPredictor, PredictsAsOneThatHasSeenTheLastFiveReadingsAlone) {
  // Evenly sampled, with gaps and a frequency that is refined now and then: what is kept from before changes no bit.
  const double omegas[] = {30.0, 30.01, 45.0};
  MotionPredictor lasting;
  std::vector<std::pair<std::int64_t, double>> readings;
  std::int64_t t_ns = 0;
  int predicted = 0;
  for (int i = 0; i < 300; ++i) {
    const std::int64_t before_ns = t_ns;
    t_ns += i % 37 == 36 ? 9'000'000 : i % 50 > 44 ? 3'000'000 + 1'000 * i : 4'000'000;
    const double omega = omegas[i / 100];
    MotionPredictor fresh;
    for (std::size_t j = readings.size() - std::min<std::size_t>(5, readings.size()); j < readings.size(); ++j)
      fresh.add(readings[j].first, readings[j].second);
    const MotionPredictor::Prediction one = lasting.predict(t_ns, before_ns, omega),
                                      other = fresh.predict(t_ns, before_ns, omega);
    EXPECT_EQ(one.value, other.value) << i;
    EXPECT_EQ(one.gain, other.gain) << i;
    if (one.gain > 0) {
      EXPECT_EQ(lasting.slope(one, t_ns), fresh.slope(other, t_ns)) << i;
      ++predicted;
    }
    readings.emplace_back(t_ns, std::sin(1e-9 * omega * static_cast<double>(t_ns)) + 0.001 * (i * 7 % 11));
    lasting.add(readings.back().first, readings.back().second);
  }
  EXPECT_GT(predicted, 200);
}

TEST(RefreshStamps, AValueOfAHeldRegisterIsDatedBetweenTheTwoReadings) {
  RefreshStamps stamps;
  MotionGate::Reading reading{10'000'000, 1.0};
  stamps.date(reading, true);
  stamps.take(-1.0);
  EXPECT_EQ(reading.t_ns, 10'000'000);  // nothing is known of when the reading before still held
  stamps.see_old(20'000'000);
  reading = {30'000'000, 2.0};
  stamps.next();
  stamps.date(reading, true);
  EXPECT_EQ(reading.t_ns, 25'000'000);
  EXPECT_EQ(reading.refresh_half_ns, 5'000'000u);
  EXPECT_EQ(stamps.half_s(), 0.0);
  stamps.take(reading.refresh_half_ns);
  EXPECT_DOUBLE_EQ(stamps.half_s(), 5e-3);
}

TEST(EvenRuns, SixteenRunsOfLikeLengthThatGoBackByOtherStepsTell) {
  EvenRuns runs;
  const double jumps[] = {3.0, 1.0, -2.5, -1.5};
  for (int i = 0; i < 15; ++i) runs.add(4 + i % 2, jumps[i % 4], jumps[(i + 1) % 4]);
  EXPECT_FALSE(runs.found());
  runs.add(4, 3.0, 1.0);
  EXPECT_TRUE(runs.found());
  runs.add(6, 3.0, 1.0);
  EXPECT_FALSE(runs.found());
}

TEST(EvenRuns, AMotionThatGoesBackOverTheSameStepIsNoHeldRegister) {
  EvenRuns runs;
  for (int i = 0; i < 100; ++i) runs.add(4, i % 2 ? 1.0 : -1.0, i % 2 ? -1.0 : 1.0);
  EXPECT_FALSE(runs.found());
}

TEST(RepeatBeat, RepeatsAtRegularDistancesTellAndRandomOnesDoNot) {
  const auto play = [](RepeatBeat& beat, int distance) {
    for (int i = 0; i < distance; ++i) beat.next();
    beat.repeat(true, 1.0, 1e-6, 0.5);
  };
  RepeatBeat regular, random;
  for (int i = 0; i < 5; ++i) play(regular, 50);
  EXPECT_TRUE(regular.found());
  for (int i = 0; i < 100; ++i) play(random, 40 + 31 * i % 97);
  EXPECT_FALSE(random.found());
  for (int i = 0; i < 200; ++i) regular.next();
  EXPECT_FALSE(regular.found()) << "it has been silent for four beats";
}

TEST(RepeatedAnswers, RepeatsCountWhereTheMotionIsSteep) {
  RepeatedAnswers answers;
  const auto mean = [] { return 1.0; };
  answers.add(2, 1.2, 1.3, 0.5, mean);
  answers.add(1, 1.2, 1.3, 0.5, mean);
  answers.add(2, 1.2, -1.3, 0.5, mean);  // the motion turns
  answers.add(2, 0.2, 1.3, 0.5, mean);   // and here it is slow
  answers.add(2, 0.8, 1.3, 0.5, mean);   // slower than the mean
  answers.add(2, 1.2, 1.3, 1.25, mean);  // less than the step tells
  EXPECT_EQ(answers.places(), 3);
  EXPECT_EQ(answers.repeats(), 1);
}

TEST(RecurringNumbers, ANumberReturnsWhereTheMotionTurnsThereAndBack) {
  RecurringNumbers numbers;
  numbers.add(-9.0, 1, 9.0, false);
  numbers.add(9.0, 1, 1.0, true);
  numbers.add(1.0, 1, 2.0, true);
  numbers.add(2.0, 1, 3.0, false);
  numbers.add(3.0, 1, 2.0, true);  // an answer of two polls ago …
  EXPECT_EQ(numbers.returned(), 0);
  numbers.add(2.0, 1, 5.0, true);  // … and the motion goes on
  EXPECT_EQ(numbers.returned(), 1);
  numbers.add(5.0, 1, 3.0, true);  // a crest: it goes on downwards
  numbers.add(3.0, 1, 2.0, false);
  EXPECT_EQ(numbers.returned(), 1);
}

}  // namespace
}  // namespace dwell
