#include "core/fit/mains.hpp"

#include <gtest/gtest.h>

#include <random>

namespace dwell {
namespace {

SamplingRegularity sampled(double rate_hz, double jitter_s, double lost) {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  SamplingRegularity sampling;
  double last_s = 0.0;
  for (int i = 1; i < 5000; ++i) {
    if (uniform(rng) < lost) continue;
    const double t_s = i / rate_hz + jitter_s * normal(rng);
    sampling.add(t_s - last_s);
    last_s = t_s;
  }
  return sampling;
}

TEST(SamplingRegularity, FindsWhereTheMainsComeToLie) {
  EXPECT_NEAR(sampled(1000, 0, 0).distance_hz(50, 49), 1.0, 1e-6);
  EXPECT_NEAR(sampled(55, 0, 0).distance_hz(50, 5.2), 0.2, 1e-3);  // 55 - 50
  EXPECT_NEAR(sampled(45, 0, 0).distance_hz(50, 5.2), 0.2, 1e-3);  // 50 - 45
  EXPECT_NEAR(sampled(20, 0, 0).distance_hz(50, 9.5), 0.5, 1e-3);  // 2.5 rates
}

TEST(SamplingRegularity, LostSamplesAreNoOtherRate) {
  EXPECT_NEAR(sampled(55, 0, 0.05).distance_hz(50, 5.2), 0.2, 0.05);
}

TEST(SamplingRegularity, ABurstAtTheBeginningIsNotTheRate) {
  SamplingRegularity sampling;
  for (int i = 0; i < 20; ++i) sampling.add(1e-4);
  for (int i = 0; i < 500; ++i) sampling.add(1.0 / 55);
  EXPECT_NEAR(sampling.distance_hz(50, 5.2), 0.2, 1e-3);
}

// A mean that keeps a thousandth of it moves an alias by a thousandth of the line.
TEST(SamplingRegularity, AGapAmongTheFirstFewStepsDoesNotMoveTheRate) {
  for (int gap_at = 0; gap_at < 6; ++gap_at) {
    SamplingRegularity sampling;
    for (int i = 0; i < 500; ++i) sampling.add((i == gap_at ? 2 : 1) / 55.0);
    EXPECT_NEAR(sampling.distance_hz(50, 5.2), 0.2, 1e-9) << gap_at;
  }
}

TEST(SamplingRegularity, JitterLeavesOnlyTheLineItself) {
  EXPECT_NEAR(sampled(55, 0.02, 0).distance_hz(50, 5.2), 44.8, 1e-6);
}

}  // namespace
}  // namespace dwell
