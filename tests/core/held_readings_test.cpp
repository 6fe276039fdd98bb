// A register that is refreshed more slowly than it is read, and motions that only look like one.
#include "core/intake/held_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dwell {
namespace {

struct ReadMotion {
  double readings_a_period, noise = 0.0, step = 0.0, end = INFINITY;  // of an amplitude of 1
};

// So many readings, each given `times` times.
bool held(const ReadMotion& motion, int readings, int times, std::uint64_t seed) {
  HeldReadings held;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double phase = std::uniform_real_distribution<double>(0.0, 6.0)(random);
  double shown = 0.0;
  for (int i = 0; i < readings; ++i) {
    if (i % times == 0) {
      shown = std::sin(2 * M_PI * i / motion.readings_a_period + phase) + motion.noise * normal(random);
      if (motion.step > 0) shown = motion.step * std::round(shown / motion.step);
      shown = std::min(shown, motion.end);
    }
    held.add(shown, motion.step);
  }
  return held.held();
}

TEST(HeldReadings, ARegisterRefreshedEveryOtherReadingIsSeenHoweverFewReadingsAPeriod) {
  for (const double readings : {6.0, 8.0, 10.0, 10.003, 12.0, 14.0})
    for (const double noise : {1e-4, 1e-2})
      for (std::uint64_t seed = 1; seed <= 20; ++seed)
        EXPECT_TRUE(held({readings, noise}, 500, 2, seed)) << readings << " readings a period, noise " << noise;
}

TEST(HeldReadings, OfAMotionOfFewReadingsAPeriodNoneIsHeldHoweverItIsRoundedOrClipped) {
  std::uint64_t seed = 0;
  for (const double readings : {3.0, 4.0, 5.0, 6.01, 8.0, 10.0, 10.003, 12.0, 16.0})
    for (const double noise : {0.0, 1e-3, 0.02, 0.2})
      for (const double step : {0.0, 1e-3, 0.02, 0.3, 0.7, 1.1})
        for (const double end : {static_cast<double>(INFINITY), 0.95, 0.55})
          EXPECT_FALSE(held({readings, noise, step, end}, 4000, 1, ++seed))
              << readings << " readings a period, noise " << noise << ", step " << step << ", end " << end;
}

TEST(HeldReadings, AChannelThatWasStuckOnceOrTwiceIsNotHeldSinceThen) {
  for (const int spells : {1, 2})
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      HeldReadings held;
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal;
      std::uniform_int_distribution<int> long_(100, 900);
      double shown = 0.0;
      int until = 0, left = spells;
      for (int i = 0; i < 8000; ++i) {
        if (left > 0 && i == 1000 * (spells - left + 1)) {
          until = i + long_(random);
          --left;
        }
        if (i >= until) shown = std::sin(2 * M_PI * i / 50.03) + 1e-3 * normal(random);
        held.add(shown, 0.0);
        ASSERT_FALSE(held.held()) << spells << " spells, seed " << seed << ", reading " << i;
      }
    }
}

// Whether the channel counts as held after each of the readings; those of a register refreshed every `ratio` readings,
// at instants that jitter by ± that part of a reading.
bool held_at_rate(double ratio, double jitter, double noise, int readings, std::uint64_t seed) {
  HeldReadings held;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double phase = uniform(random);
  double shown = NAN, next = phase;
  for (int i = 0; i < readings; ++i) {
    for (int n = 0; next <= i; ++n) {
      shown = std::sin(2 * M_PI * next / 124.3) + noise * normal(random);
      const double k = std::round((next - phase) / ratio) + 1;
      next = std::max(std::nextafter(next, INFINITY), phase + k * ratio + jitter * uniform(random));
    }
    if (!std::isnan(shown)) held.add(shown, 0.0);
  }
  return held.held();
}

TEST(HeldReadings, ARegisterIsHeldAtWhateverRateThoughItsRefreshesJitter) {
  for (const double ratio : {1.01, 1.02, 1.05, 1.1, 1.16, 1.3, 1.5, 1.77, 2.0, 2.5, 5.0, 7.3, 16.0})
    for (const double jitter : {0.0, 0.02, 0.05, 0.1, 0.2})
      for (const double noise : {0.0, 1e-3, 1e-2})
        for (std::uint64_t seed = 1; seed <= 10; ++seed)
          EXPECT_TRUE(held_at_rate(ratio, jitter, noise, 6000, seed))
              << ratio << " readings a refresh, jitter " << jitter << ", noise " << noise << ", " << seed;
}

// Nearly as often refreshed as read, it shows by its beat. Later it must repeat more readings than chance brings.
TEST(HeldReadings, ARegisterIsHeldAfterFewOfItsRepeats) {
  for (const double ratio : {1.004, 1.01, 1.02, 1.05, 1.1, 1.3, 1.5, 2.5, 7.3})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const int repeats = ratio < 1.03 ? 25 : 160;
      EXPECT_TRUE(held_at_rate(ratio, 0.02, 1e-3, static_cast<int>(repeats * ratio / (ratio - 1)), seed))
          << ratio << " readings a refresh, " << seed;
    }
}

// A gateway answers again with what it answered before. Four repeats in a row may come with a beat by chance.
TEST(HeldReadings, RepeatsAtRandomAreNoRegister) {
  int taken_for_a_register = 0, trials = 0;
  for (const double share : {0.003, 0.005, 0.01, 0.02, 0.05, 0.1})
    for (const double noise : {0.0, 1e-3, 1e-2})
      for (const double readings : {12.0, 40.3, 124.3})
        for (std::uint64_t seed = 1; seed <= 40; ++seed) {
          HeldReadings held;
          std::mt19937_64 random(seed);
          std::normal_distribution<double> normal;
          std::uniform_real_distribution<double> uniform;
          double shown = 0.0;
          bool ever = false;
          for (int i = 0; i < 15000; ++i) {
            if (uniform(random) >= share) shown = std::sin(2 * M_PI * i / readings) + noise * normal(random);
            held.add(shown, 0.0);
            ever = ever || held.held();
          }
          ++trials;
          taken_for_a_register += ever;
          // Fewer, or of a motion of few numbers, may still be chance.
          EXPECT_TRUE(held.repeats_tell_nothing() || share < 0.01 || noise == 0 || readings < 40)
              << share << " of the readings, noise " << noise << ", " << readings << " readings a period, " << seed;
        }
  EXPECT_LE(taken_for_a_register, trials / 100);
}

// A dwell that a pattern has misled once is measured the next time.
TEST(HeldReadings, WhatWasTakenForARegisterIsNoneInTheNextHoldIfItsRepeatsAreRandom) {
  HeldReadings held;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> normal;
  const auto motion = [&](int i) { return std::sin(2 * M_PI * i / 124.3) + 1e-3 * normal(random); };
  double shown = 0.0;
  int i = 0;
  for (; i < 3000; ++i) {
    if (i % 50 != 0) shown = motion(i);
    held.add(shown, 0.0);
  }
  ASSERT_TRUE(held.held());
  for (; i < 10'000; ++i) {
    if (uniform(random) >= 0.02) shown = motion(i);
    held.add(shown, 0.0);
  }
  EXPECT_TRUE(held.held());
  held.restart();
  EXPECT_FALSE(held.held());
}

// Of 4000 readings the part `stale` are as old as that many polls.
HeldReadings::Again again_of(const ReadMotion& motion, double stale, int polls, std::uint64_t seed) {
  HeldReadings held;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  double shown[4] = {};
  for (int i = 0; i < 4000; ++i) {
    double reading = std::sin(2 * M_PI * i / motion.readings_a_period) + motion.noise * normal(random);
    if (motion.step > 0) reading = motion.step * std::round(reading / motion.step);
    shown[i % 4] = std::min(reading, motion.end);
    held.add(uniform(random) < stale ? shown[(i + 4 - polls) % 4] : shown[i % 4], motion.step);
  }
  return held.again(0.0);
}

TEST(HeldReadings, AnAnswerOfAnEarlierPollShowsAndThereIsNoneInAHealthyMotion) {
  std::uint64_t seed = 0;
  for (const double readings : {12.0, 13.7, 21.0, 33.37, 40.0, 40.71, 99.15, 100.0, 403.3})
    for (const double noise : {0.0, 1e-3, 0.02}) {
      const auto at = [&](double step) {
        return " at " + std::to_string(readings) + " readings a period, noise " + std::to_string(noise) + ", step " +
               std::to_string(step);
      };
      // Where the answer before was an old one too, the newest need not repeat it.
      for (const double stale : {0.2, 0.4}) {
        const double shows = stale * (1 - stale);
        EXPECT_NEAR(again_of({readings, noise}, stale, 1, ++seed).one_before, shows, 0.3 * shows) << at(0.0);
        // With few readings a period, or a whole number of them, no two differ by little: what chance brings is not
        // known.
        if (readings < 33.0 || readings == std::round(readings)) continue;
        EXPECT_NEAR(again_of({readings, noise}, stale, 2, ++seed).older, shows, 0.5 * shows) << at(0.0);
      }
      for (const double step : {0.0, 1e-6, 1e-3, 0.01, 0.1, 0.5})
        for (const double end : {static_cast<double>(INFINITY), 0.9}) {
          const HeldReadings::Again again = again_of({readings, noise, step, end}, 0.0, 0, ++seed);
          EXPECT_EQ(again.older, 0.0) << at(step) << ", end " << end;
          EXPECT_EQ(again.one_before, 0.0) << at(step) << ", end " << end;
        }
    }
}

// Steps of a twentieth of the amplitude, 21 readings a period.
TEST(HeldReadings, RepeatsShowWhereRoundingIsAsCoarseAsTheNoise) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    EXPECT_NEAR(again_of({21.0, 0.006, 0.05}, 0.23, 1, seed).one_before, 0.23 * 0.77, 0.08) << seed;
    EXPECT_EQ(again_of({21.0, 0.006, 0.05}, 0.0, 1, seed).one_before, 0.0) << seed;
  }
}

}  // namespace
}  // namespace dwell
