#include "core/fit/folding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

TEST(Folding, TheNinthHarmonicReadsAsTheFundamentalAtTenSamplesAPeriod) {
  const Folding folding = worst_folding(40, 4, 3);
  EXPECT_EQ(folding.harmonic, 7);  // 10 - 7 = 3: onto the third; the ninth follows
  EXPECT_EQ(folding.onto, 3);
  EXPECT_NEAR(folding.apart_hz, 0, 1e-12);
}

TEST(Folding, ARateFarAboveTheHarmonicsFoldsNone) {
  EXPECT_EQ(worst_folding(1000, 4, 3).harmonic, 0);
  EXPECT_EQ(rate_beside_foldings(1000, 4, 3), 1000);
}

// Against samples: the folded harmonic and the line it is said to read as agree at every instant.
TEST(Folding, WhatIsSaidToReadAlikeReadsAlike) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 300; ++trial) {
    const double drive_hz = 0.5 + 1e-3 * static_cast<double>(rng() % 10000);
    const int fitted = 1 + static_cast<int>(rng() % 8);
    const double rate_hz = drive_hz * (2 * (fitted + 1) + 0.01 * static_cast<double>(rng() % 4000));
    const Folding folding = worst_folding(rate_hz, drive_hz, fitted);
    if (folding.harmonic == 0) continue;
    double closest = 2;
    for (const double sign : {-1.0, 1.0}) {
      const double line_hz = folding.onto * drive_hz + sign * folding.apart_hz;
      double differ = 0;
      for (int i = 0; i < 50; ++i)
        differ = std::max(differ, std::abs(std::cos(kTwoPi * folding.harmonic * drive_hz * i / rate_hz) -
                                           std::cos(kTwoPi * line_hz * i / rate_hz)));
      closest = std::min(closest, differ);
    }
    ASSERT_LT(closest, 1e-9) << "trial " << trial;
  }
}

TEST(Folding, TheShiftedRateStaysWithinOnePercentAndIsNeverWorse) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 1000; ++trial) {
    const double drive_hz = 0.5 + 1e-3 * static_cast<double>(rng() % 10000);
    const int fitted = 1 + static_cast<int>(rng() % 8);
    const double rate_hz = drive_hz * (2 * (fitted + 1) + static_cast<double>(rng() % 60));
    const double shifted_hz = rate_beside_foldings(rate_hz, drive_hz, fitted);
    ASSERT_LE(std::abs(shifted_hz / rate_hz - 1), kRateShift + 1e-12);
    ASSERT_GE(shifted_hz, 2 * (fitted + 1) * drive_hz - 1e-9);
    const Folding before = worst_folding(rate_hz, drive_hz, fitted);
    const Folding after = worst_folding(shifted_hz, drive_hz, fitted);
    if (before.harmonic == 0) {
      ASSERT_EQ(shifted_hz, rate_hz);
    } else {
      // 1 % of N samples a period moves what folds by 0.01 N f, once for each multiple of the rate.
      ASSERT_GE(after.distance_hz(), std::min(0.009 * rate_hz * (fitted + 1), kClearOfHarmonics * drive_hz))
          << rate_hz / drive_hz << " H " << fitted;
    }
  }
}

TEST(Folding, ARateThatIsClearAlreadyIsLeftAsItIs) { EXPECT_EQ(rate_beside_foldings(41.4, 4, 3), 41.4); }

}  // namespace
}  // namespace dwell
