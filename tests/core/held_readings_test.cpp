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

// How many of 4000 readings are one of the last numbers again; `stale`: the part that is the reading two before.
std::int64_t older_again(const ReadMotion& motion, double stale, std::uint64_t seed) {
  HeldReadings held;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  double shown[3] = {};
  for (int i = 0; i < 4000; ++i) {
    double reading = std::sin(2 * M_PI * i / motion.readings_a_period) + motion.noise * normal(random);
    if (motion.step > 0) reading = motion.step * std::round(reading / motion.step);
    shown[i % 3] = std::min(reading, motion.end);
    held.add(uniform(random) < stale ? shown[(i + 1) % 3] : shown[i % 3], motion.step);
  }
  return held.older_again();
}

TEST(HeldReadings, RepeatsOfOlderReadingsAreCountedAndThereAreNoneInAHealthyMotion) {
  std::uint64_t seed = 0;
  for (const double readings : {33.37, 40.71, 99.15, 403.3})
    for (const double noise : {0.0, 1e-3, 0.02}) {
      EXPECT_GT(older_again({readings, noise}, 0.4, ++seed), 800) << readings << " readings a period, noise " << noise;
      EXPECT_GT(older_again({readings, noise}, 0.2, ++seed), 400) << readings << " readings a period, noise " << noise;
      for (const double step : {0.0, 1e-6, 1e-3, 0.01, 0.1, 0.5})
        for (const double end : {static_cast<double>(INFINITY), 0.9})
          EXPECT_EQ(older_again({readings, noise, step, end}, 0.0, ++seed), 0)
              << readings << " readings a period, noise " << noise << ", step " << step << ", end " << end;
    }
}

}  // namespace
}  // namespace dwell
