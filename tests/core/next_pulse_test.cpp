#include "core/drive/next_pulse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dwell {
namespace {

constexpr double kPulsePeriod_s = 0.25;

std::int64_t pulse_ns(double k) { return 5'000'000'000 + std::llround(1e9 * kPulsePeriod_s * k); }

NextPulse after_pulses(int pulses, double jitter_s, std::uint64_t seed = 1) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  NextPulse next;
  next.begin(1.01 * kPulsePeriod_s);
  for (int k = 0; k < pulses; ++k) next.take(pulse_ns(k + jitter_s / kPulsePeriod_s * normal(rng)), k);
  return next;
}

TEST(NextPulse, OnePulseForetellsByTheFirstGuessAlone) {
  const NextPulse next = after_pulses(1, 0.0);
  EXPECT_DOUBLE_EQ(next.T_s(), 1.01 * kPulsePeriod_s);
  EXPECT_NEAR(next.periods_to(pulse_ns(1.01)), 1.0, 1e-9);
}

TEST(NextPulse, TwoPulsesForetellByTheirDistance) {
  const NextPulse next = after_pulses(2, 0.0);
  EXPECT_NEAR(next.T_s(), kPulsePeriod_s, 1e-9);
  EXPECT_NEAR(next.periods_to(pulse_ns(4)), 3.0, 1e-8);
  EXPECT_EQ(next.newest_k(), 1);
  EXPECT_EQ(next.newest_ns(), pulse_ns(1));
}

TEST(NextPulse, ALateNewestPulseDelaysTheNextByAPartOfThatOnly) {
  NextPulse next = after_pulses(15, 0.0);
  next.take(pulse_ns(15.08), 15);
  // Of 16 points the line takes about a quarter of what the last is off.
  EXPECT_NEAR(next.periods_to(pulse_ns(16)), 1.0, 0.03);
}

TEST(NextPulse, FewPulsesAllowAsMuchAsIsAllowedBeforeTheJitterIsKnown) {
  EXPECT_EQ(after_pulses(15, 0.0).allowed(), NextPulse::kJitter);
}

TEST(NextPulse, WhatIsAllowedGrowsWithTheJitterBetweenItsLimits) {
  const double exact = after_pulses(40, 0.0).allowed(), some = after_pulses(40, 0.01 * kPulsePeriod_s).allowed(),
               much = after_pulses(40, 0.2 * kPulsePeriod_s).allowed();
  EXPECT_DOUBLE_EQ(exact, 0.02);
  EXPECT_NEAR(some, 0.08, 0.04) << "eight standard deviations";
  EXPECT_DOUBLE_EQ(much, 0.2);
}

TEST(NextPulse, AHoleInTheNumbersDoesNotChangeThePeriod) {
  NextPulse next = after_pulses(10, 0.0);
  next.take(pulse_ns(17), 17);
  EXPECT_NEAR(next.T_s(), kPulsePeriod_s, 1e-9);
  EXPECT_NEAR(next.periods_to(pulse_ns(18)), 1.0, 1e-8);
}

TEST(NextPulse, AnotherTrainForgetsTheFormersPulses) {
  NextPulse next = after_pulses(40, 0.01 * kPulsePeriod_s);
  next.begin(0.1);
  next.take(pulse_ns(60), 0);
  EXPECT_DOUBLE_EQ(next.T_s(), 0.1);
  EXPECT_EQ(next.allowed(), NextPulse::kJitter);
}

}  // namespace
}  // namespace dwell
