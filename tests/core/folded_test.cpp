#include "core/fit/folded.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

SamplingRegularity sampled_at(double rate_hz, double jitter = 0.0) {
  SamplingRegularity sampling;
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> uniform(-jitter, jitter);
  double before_s = 0.0;
  for (int i = 1; i < 4000; ++i) {
    const double t_s = (i + uniform(rng)) / rate_hz;
    sampling.add(t_s - before_s);
    before_s = t_s;
  }
  return sampling;
}

Rig mount_rig(double f) { return rig_of({Boundary::clamped, {}, {60000}, {60}}, f); }

Folded folded_at(double rate_hz, double jitter = 0.0, double seconds = 20) {
  const Rig rig = mount_rig(4);
  return folded_onto_fundamental(rig, rig.channels[0], sampled_at(rate_hz, jitter), 4, seconds);
}

TEST(Folded, AWholeMultipleOfTheDriveFoldsTheHarmonicsBesideIt) {
  EXPECT_EQ(folded_at(40).order, 9);
  EXPECT_TRUE(folded_at(40).exactly);
  EXPECT_NEAR(folded_at(40).part, 0.3 / 9, 1e-4);
  EXPECT_EQ(folded_at(48).order, 11);
  EXPECT_EQ(folded_at(42).order, 20);  // 20 f = 2 · 42 Hz - f
}

// The mean over T of an alias that turns x times within T is sin πx / πx of it.
TEST(Folded, AnAliasCountsUntilOneTurnWithinTheDwellAveragesItOut) {
  for (const double turns : {0.3, 0.5, 0.6, 0.9})
    EXPECT_NEAR(folded_at(40 + turns / 20).part, 0.3 / 9 * std::sin(kTwoPi / 2 * turns) / (kTwoPi / 2 * turns), 1e-4)
        << turns;
  EXPECT_EQ(folded_at(40 + 1.01 / 20).order, 0);
}

TEST(Folded, ARateBesideTellsThemApart) {
  EXPECT_EQ(folded_at(40.4).order, 0);
  EXPECT_EQ(folded_at(200).order, 0) << "harmonic 49 is none that a drive has";
  EXPECT_FALSE(folded_at(40.01).exactly) << "a fifth of a turn within the dwell";
  EXPECT_EQ(folded_at(40.01).order, 9);
  EXPECT_EQ(folded_at(40.01, 0.0, 120).order, 0) << "a turn and a fifth";
}

TEST(Folded, IrregularInstantsSpreadAnAlias) {
  EXPECT_LT(folded_at(40, 0.3).part, 0.7 * folded_at(40).part);
  EXPECT_EQ(folded_at(40, 0.5).order == 9, false);
}

TEST(Folded, WhatTheTransducerHoldsBackDoesNotFold) {
  Rig rig = mount_rig(4);
  rig.channels[0].lowpass = {FilterKind::butterworth, 2, 12, 0};
  EXPECT_NEAR(folded_onto_fundamental(rig, rig.channels[0], sampled_at(40), 4, 20).part, 0.3 / 9 / 9, 5e-4);
}

// 0.15 mm of the ninth beside 5 mm, ten readings a period: r had been 51 % off, ± 1.7 %, without a word.
TEST(Folded, AFoldedHarmonicIsWithinWhatTheDwellStates) {
  const Chain chain{Boundary::clamped, {}, {60000}, {60}};
  for (const double rate_hz : {40.0, 46.7}) {
    Drive drive = steady_drive(4, 0.005);
    drive.harmonics = {{9, 0.00015, 1.2}};
    Bench bench(chain, mount_rig(4), drive, DrivenChain::Start::steady, {.rate_hz = rate_hz, .sigma = {5e-6, 0.3}});
    bench.run(20);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 1u);
    const Dwell& dwell = bench.dwells[0];
    const Coefficient& r = dwell.elements[0].damping;
    EXPECT_LT(std::abs(r.value - 60), 2.5 * r.u) << r.value << " ± " << r.U95;
    const bool said = std::any_of(dwell.warnings.begin(), dwell.warnings.end(), [](const Warning& warning) {
      return warning.what.find(
                 "harmonic 9 of the drive, if there is any, folds onto the fundamental in y0 and reaction") == 0;
    });
    EXPECT_EQ(said, rate_hz == 40.0);
    EXPECT_EQ(dwell.elements[0].budget[0].source.find("folded harmonics of ") == 0, said);
  }
}

}  // namespace
}  // namespace dwell
