// The data that count: frequency and drift of the drive, sums that are kept up to date, what is forgotten.
#include "core/dwell/counted_data.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "tests/core/table_and_mass.hpp"

namespace dwell {
namespace {

constexpr double kCountedRate_hz = 200.0, kCountedNoise = 1e-3, kCountedPeriod_s = 0.25;

// A table that moves at f + drift·t/2 Hz with an amplitude of 1, and a mass of 2 behind it.
struct CountedBench {
  explicit CountedBench(const Rig& given, double f, double drift = 0.0)
      : rig(given), f_hz(f), drift_hz_per_s(drift), channels(rig), reference(rig), data(rig, channels, reference) {
    data.open(0);
  }
  // On to that instant.
  void run_to(double end_s) {
    std::normal_distribution<double> normal(0.0, kCountedNoise);
    for (; static_cast<double>(readings) / kCountedRate_hz < end_s; ++readings) {
      const double t_s = static_cast<double>(readings) / kCountedRate_hz;
      const auto t_ns = static_cast<std::int64_t>(std::llround(1e9 * t_s));
      while (t_ns >= data.blocks().open_end_ns()) {
        const std::int64_t end_ns = data.blocks().open_end_ns();
        data.close();
        data.take_block(end_ns);
        data.open(end_ns);
      }
      const double phase = kTwoPi * (f_hz + 0.5 * drift_hz_per_s * t_s) * t_s;
      data.add(0, t_ns, std::sin(phase) + normal(random));
      data.add(1, t_ns, 2.0 * std::sin(phase - 1.0) + normal(random));
    }
  }

  Rig rig;
  double f_hz, drift_hz_per_s;
  LiveChannels channels;
  DriveReference reference;
  CountedData data;
  std::mt19937_64 random{1};
  long readings = 0;
};

TEST(CountedData, FindsTheFrequencyOfASteadyDriveWithinItsUncertainty) {
  CountedBench bench(table_and_mass(), 4.0003);
  bench.run_to(20.0);
  EXPECT_FALSE(bench.data.sums_valid());
  EXPECT_FALSE(bench.data.knows_omega());
  const auto table = bench.data.resum(0);
  ASSERT_TRUE(table);
  EXPECT_TRUE(bench.data.sums_valid() && bench.data.knows_omega());
  EXPECT_GT(table->u_omega, 0.0);
  EXPECT_LT(std::abs(bench.data.omega() - kTwoPi * 4.0003), 4 * table->u_omega);
  EXPECT_NEAR(std::abs(table->fit.X[0]), 1.0, 1e-3);
  EXPECT_NEAR(std::abs(bench.data.fit_counted(1).X[0]), 2.0, 1e-3);
  bench.data.forget_omega();
  EXPECT_EQ(bench.data.omega(), kTwoPi * 4.0);
}

TEST(CountedData, TheFirstBlocksTakenAtAWrongFrequencyDoNotCount) {
  CountedBench bench(table_and_mass(), 4.05);
  bench.run_to(1.0);
  EXPECT_EQ(bench.data.blocks().block(0).begin_ns, 0);
  bench.data.take_omega(kTwoPi * 4.05);
  bench.run_to(20.0);
  const auto table = bench.data.resum(0);
  ASSERT_TRUE(table);
  EXPECT_GE(bench.data.blocks().block(0).begin_ns, 1'000'000'000);
  EXPECT_LT(std::abs(bench.data.omega() - kTwoPi * 4.05), 4 * table->u_omega);
  EXPECT_NEAR(std::sqrt(table->fit.sigma2), kCountedNoise, 0.1 * kCountedNoise);
}

TEST(CountedData, WithoutDataNothingIsCounted) {
  CountedBench bench(table_and_mass(), 4.0);
  EXPECT_FALSE(bench.data.resum(0));
  EXPECT_FALSE(bench.data.sums_valid());
}

TEST(CountedData, OneWindowIsEnoughToAcquireTheFrequency) {
  CountedBench bench(table_and_mass(), 4.1);
  bench.run_to(1.3 * kCountedPeriod_s);
  ASSERT_GE(bench.data.blocks().count(), kQuarters);
  bench.data.acquire(0, kQuarters, 125'000'000, bench.data.nominal_omega());
  EXPECT_NEAR(bench.data.omega() / kTwoPi, 4.1, 0.01);
}

TEST(CountedData, TheRunningSumsStayThoseOfAllBlocksAndAreRefinedOnceTheDataHaveGrownByASixth) {
  CountedBench bench(table_and_mass(), 4.0);
  bench.run_to(20.0);
  bench.data.resum(0);
  EXPECT_FALSE(bench.data.wants_refining());
  bench.run_to(22.0);
  EXPECT_FALSE(bench.data.wants_refining());
  const Totals& sums = bench.data.sums();
  const HarmonicFit kept = bench.data.fit_counted(1);
  const HarmonicFit anew = bench.data.fit(1, 0, bench.data.blocks().count(), bench.data.omega(), sums.t_ref_ns());
  EXPECT_EQ(kept.samples, anew.samples);
  EXPECT_LT(std::abs(kept.X[0] - anew.X[0]), 1e-12);
  bench.run_to(24.0);
  EXPECT_TRUE(bench.data.wants_refining());
}

TEST(CountedData, WhatIsOlderThanTheMemoryIsForgottenAndTheSumsHoldNoLonger) {
  Rig rig = table_and_mass();
  rig.memory_s = 10.0;
  CountedBench bench(rig, 4.0);
  bench.run_to(9.0);
  bench.data.resum(0);
  EXPECT_TRUE(bench.data.sums_valid());
  bench.run_to(12.0);
  EXPECT_FALSE(bench.data.sums_valid());
  EXPECT_GT(bench.data.blocks().block(0).begin_ns, 1'000'000'000);
}

TEST(CountedData, ADriftThatTurnsThePhaseIsFollowedAndOneThatIsStatedAwayIsNot) {
  CountedBench drifting(table_and_mass(), 4.0, 2e-4);
  drifting.run_to(60.0);
  drifting.data.resum(0);
  EXPECT_NEAR(drifting.data.drift().rate, kTwoPi * 2e-4, kTwoPi * 2e-5);
  const auto start_omega = drifting.data.omega_at(0, drifting.data.omega());
  EXPECT_NEAR(start_omega / kTwoPi, 4.0, 1e-3);
  EXPECT_EQ(drifting.data.bend(drifting.data.drift().about_ns), 0.0);

  Rig stated = table_and_mass();
  stated.excitation.reference = Reference::fixed;
  stated.excitation.clock_u = 0.0;
  CountedBench exact(stated, 4.0, 2e-4);
  exact.run_to(60.0);
  exact.data.resum(0);
  EXPECT_EQ(exact.data.drift().rate, 0.0) << "an exactly stated frequency has no drift";
}

TEST(CountedData, ADwellThatIsTakenBackKeepsTheFrequencyOfThatInstantWithoutTheDrift) {
  CountedBench bench(table_and_mass(), 4.0, 2e-4);
  bench.run_to(60.0);
  bench.data.resum(0);
  const double then = bench.data.omega_at(60'000'000'000, bench.data.omega());
  bench.data.stop_counting(60'000'000'000);
  EXPECT_EQ(bench.data.omega(), then);
  EXPECT_EQ(bench.data.drift().rate, 0.0);
  EXPECT_FALSE(bench.data.sums_valid());
}

TEST(CountedData, WhatIsReportedRestsOnTheBlocksAskedForAndTheOpenOneIfAskedFor) {
  CountedBench bench(table_and_mass(), 4.0);
  bench.run_to(10.02);
  const int all = bench.data.blocks().count();
  const std::int64_t now_ns = 10'020'000'000;
  EXPECT_TRUE(bench.data.gather(0, all, false, now_ns, 0).sums_valid);
  const double closed = fit_harmonics(bench.data.totals(), 0, 2, 0.0).samples;
  static_cast<void>(bench.data.gather(0, all, true, now_ns, 0));
  EXPECT_EQ(fit_harmonics(bench.data.totals(), 0, 2, 0.0).samples, static_cast<double>(bench.readings));
  EXPECT_LT(closed, static_cast<double>(bench.readings));
  static_cast<void>(bench.data.gather(all - 4, all, false, now_ns, 0));
  EXPECT_EQ(fit_harmonics(bench.data.totals(), 0, 2, 0.0).samples, 50);
}

}  // namespace
}  // namespace dwell
