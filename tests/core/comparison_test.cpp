#include "core/verify/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

Eigen::VectorXd sine(double amplitude, double phase_rad) {
  constexpr Eigen::Index kCount = 1000;  // ten whole turns
  Eigen::VectorXd out(kCount);
  for (Eigen::Index i = 0; i < kCount; ++i)
    out(i) = amplitude * std::sin(kTwoPi * 10 * static_cast<double>(i) / static_cast<double>(kCount) + phase_rad);
  return out;
}

TEST(Comparison, OfASeriesWithItselfIsPerfect) {
  ChannelComparison seen;
  compare(sine(2, 0), sine(2, 0), seen);
  EXPECT_EQ(seen.samples, 1000U);
  EXPECT_NEAR(seen.rms, std::sqrt(2.0), 1e-12);
  EXPECT_EQ(seen.error, 0.0);
  EXPECT_EQ(seen.fit_percent, 100.0);
  EXPECT_NEAR(seen.sprague_geers.combined, 0.0, 1e-7);
}

TEST(Comparison, TellsAWrongGainByMagnitudeAlone) {
  ChannelComparison seen;
  compare(sine(1.1, 0), sine(1, 0), seen);
  EXPECT_NEAR(seen.error, 0.1, 1e-12);
  EXPECT_NEAR(seen.fit_percent, 90.0, 1e-9);
  EXPECT_NEAR(seen.sprague_geers.magnitude, 0.1, 1e-12);
  EXPECT_NEAR(seen.sprague_geers.phase, 0.0, 1e-7);
}

TEST(Comparison, TellsADelayByPhaseAlone) {
  ChannelComparison seen;
  compare(sine(1, 0.2), sine(1, 0), seen);
  EXPECT_NEAR(seen.error, 2 * std::sin(0.1), 1e-12);
  EXPECT_NEAR(seen.sprague_geers.magnitude, 0.0, 1e-12);
  EXPECT_NEAR(seen.sprague_geers.phase, 0.2 / (kTwoPi / 2), 1e-9);
}

}  // namespace
}  // namespace dwell
