#include "core/motion/noise_of_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

struct Readings {
  std::vector<double> t, value;
};

// A sine of 1 Hz with noise.
Readings sine(double per_period, double amplitude, double sigma, int count, std::mt19937_64& rng, double jitter = 0.0) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  Readings out;
  for (int i = 0; i < count; ++i) {
    out.t.push_back((i + jitter * uniform(rng)) / per_period);
    out.value.push_back(amplitude * std::sin(kTwoPi * out.t.back()) + sigma * normal(rng));
  }
  return out;
}

TEST(NoiseOfReadings, IsNearTheNoiseOfASineThatIsReadSixTimesAPeriod) {
  std::mt19937_64 rng(1);
  for (const double per_period : {6.0, 8.0, 12.0, 100.0})
    for (const double jitter : {0.0, 0.6})
      for (int draw = 0; draw < 20; ++draw) {
        const Readings of = sine(per_period, 1.0, 0.015, 200, rng, jitter);
        const double found = noise_of_readings(of.t, of.value);
        EXPECT_GT(found, 0.5 * 0.015) << per_period << ' ' << jitter;
        EXPECT_LT(found, 2.0 * 0.015) << per_period << ' ' << jitter;
      }
}

// The choice of the least of five, which would make it too small, is made up for.
TEST(NoiseOfReadings, OfNoiseAloneIsNotTooSmall) {
  std::mt19937_64 rng(2);
  for (const int count : {60, 120, 1000}) {
    int below = 0;
    for (int draw = 0; draw < 200; ++draw) {
      const Readings of = sine(10.0, 0.0, 1.0, count, rng);
      const double found = noise_of_readings(of.t, of.value);
      EXPECT_GT(found, 0.4) << count;
      below += found < 0.8 ? 1 : 0;
    }
    EXPECT_LT(below, 40) << count;
  }
}

TEST(NoiseOfReadings, SeesOnlyTheNoiseBesideReadingsFarOffAndEqualInstants) {
  std::mt19937_64 rng(3);
  Readings of = sine(20.0, 1.0, 0.01, 1000, rng);
  for (std::size_t i = 40; i < 1000; i += 100) {
    of.value[i] += 5.0;
    of.t[i + 50] = of.t[i + 49];
  }
  const double found = noise_of_readings(of.t, of.value);
  EXPECT_GT(found, 0.8 * 0.01);
  EXPECT_LT(found, 1.3 * 0.01);
}

// Stamps rounded to a twentieth of the period, eight readings each: what it is too large by is the motion meanwhile.
TEST(NoiseOfReadings, OfRoundedStampsIsFarBelowTheMotion) {
  std::mt19937_64 rng(4);
  Readings of = sine(160.0, 1.0, 0.01, 2000, rng);
  for (double& t : of.t) t = std::floor(20.0 * t) / 20.0;
  EXPECT_GT(noise_of_readings(of.t, of.value), 0.8 * 0.01);
  EXPECT_LT(noise_of_readings(of.t, of.value), 0.03);
}

TEST(NoiseOfReadings, OfTooFewReadingsIsNotKnown) {
  EXPECT_TRUE(std::isnan(noise_of_readings({}, {})));
  EXPECT_TRUE(std::isnan(noise_of_readings({0, 1, 2, 3, 4, 5, 6, 7}, {1, 2, 1, 2, 1, 2, 1, 2})));
}

}  // namespace
}  // namespace dwell
