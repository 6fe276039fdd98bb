#include "core/drive/amplitude_excess.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dwell {
namespace {

constexpr double kWanderTolerance = 0.01, kByNoise = 1e-3;

// After so many quarters whose amplitude wanders by `wander` beside its noise, relative standard deviations.
double tolerated_after(double wander, int quarters, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  AmplitudeExcess excess;
  for (int q = 0; q < quarters; ++q)
    excess.take(std::hypot(wander, kByNoise) * normal(rng), kByNoise * kByNoise, kWanderTolerance, 0.0);
  return excess.tolerated();
}

TEST(AmplitudeExcess, NoiseAloneIsNoExcess) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) EXPECT_EQ(tolerated_after(0.0, 2000, seed), 0.0) << seed;
}

TEST(AmplitudeExcess, AWanderingAmplitudeIsToleratedByAHalfMore) {
  double mean = 0.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) mean += tolerated_after(4e-3, 2000, seed) / 50;
  EXPECT_NEAR(mean, 1.5 * 4e-3, 0.1 * 1.5 * 4e-3);
}

TEST(AmplitudeExcess, NoMoreIsToleratedThanBelongsToAnUnchangedDrive) {
  EXPECT_LE(tolerated_after(0.1, 4000, 1), 1.5 * kWanderTolerance / std::sqrt(2.0) * (1 + 1e-12));
}

TEST(AmplitudeExcess, WhatRoundingDoesIsToleratedAtOnce) {
  AmplitudeExcess excess;
  EXPECT_EQ(excess.tolerated(), 0.0);
  excess.take(0.0, kByNoise * kByNoise, kWanderTolerance, 2e-3);
  EXPECT_DOUBLE_EQ(excess.tolerated(), 6e-3);
  excess.restart();
  EXPECT_EQ(excess.tolerated(), 0.0);
}

}  // namespace
}  // namespace dwell
