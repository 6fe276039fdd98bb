// What transducers deliver, and what becomes of it: rounded, held, stuck, missing, contradictory, hostile.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/dwell/pipeline.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

TEST(Readings, AStaleChannelWithdrawsTheElementsThatNeedItAndTheyComeBackWithIt) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.run(10);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  bool lost = true;
  bench.alter = [&](Record& record, double) {
    if (lost && record.channel == 1) record.kind = Kind::tick;
  };
  Record stale;
  stale.t_ns = std::llround(bench.now_s() * 1e9);
  stale.kind = Kind::channel_state;
  stale.channel = 1;
  stale.flags = static_cast<std::uint8_t>(Fault::timeout);
  bench.push(stale);
  bench.run(11);
  const Dwell without = bench.pipeline.current();
  EXPECT_EQ(without.state, State::measuring);
  EXPECT_FALSE(without.elements[0].identifiable);
  EXPECT_EQ(without.elements[0].reason, "y1: stale, timeout");
  EXPECT_FALSE(without.elements[1].identifiable);
  EXPECT_TRUE(without.elements[2].identifiable);  // F / Y_2 needs neither y0 nor y1
  lost = false;
  bench.run(15);
  expect_within(bench.pipeline.current(), chain, 4, "after the return");
}

TEST(Readings, OneDeadChannelDoesNotKeepTheOthersFromSettling) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::rest,
              {.rate_hz = 200, .sigma = {1e-5, 1e-5, 1e-5, 0.1}});
  bench.alter = [](Record& record, double) {
    if (record.channel == 1) record.kind = Kind::tick;
  };
  bench.run(30);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  const Dwell dwell = bench.pipeline.current();
  EXPECT_EQ(dwell.elements[0].reason, "y1: no sample yet");
  for (const Warning& warning : dwell.warnings)
    EXPECT_NE(warning.kind, WarningKind::growing_chain) << "of a chain that was never identified";
  ASSERT_TRUE(dwell.elements[2].identifiable);
  EXPECT_NEAR(dwell.elements[2].stiffness.value, chain.stiffness[2], 4 * dwell.elements[2].stiffness.u);
}

TEST(Readings, AStuckReadingIsKeptOutAndItsElementsAreWithheld) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.run(20);
  bench.alter = [](Record& record, double) {
    if (record.channel == 1) record.value = 1.234e-3;
  };
  bench.run(25);
  const Dwell stuck = bench.pipeline.current();
  EXPECT_STREQ(to_string(bench.pipeline.channel(1).condition), "stuck");
  EXPECT_NE(bench.pipeline.condition_reason(1).find("stuck at one reading for 4.9"), std::string::npos)
      << bench.pipeline.condition_reason(1);
  EXPECT_STREQ(to_string(bench.pipeline.channel(2).condition), "ok");
  EXPECT_EQ(stuck.elements[0].reason, "y1: stuck at one reading");
  EXPECT_TRUE(stuck.elements[2].identifiable);
  bench.alter = nullptr;
  bench.run(60);
  // The two periods before it was recognized are in the dwell: they must be in the uncertainty.
  expect_within(bench.pipeline.current(), chain, 4, "after two periods of a stuck reading");
}

TEST(Readings, CoarseRoundingAtAMultipleOfTheDriveStaysWithinTheUncertainty) {
  const Chain chain = clamped_chain();
  for (const double step : {2e-6, 2e-5}) {  // of 2 mm
    Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady, {.rate_hz = 100, .sigma = {}});
    bench.alter = [&](Record& record, double) {
      const double q = record.channel == 3 ? 9000 * step : step;
      record.value = q * std::round(record.value / q);
    };
    bench.run(60);
    expect_within(bench.pipeline.current(), chain, 4, "rounded to " + std::to_string(step));
  }
}

// However rarely the smallest step itself is seen: here after a transient, with little noise.
TEST(Readings, RoundingIsKnownWhateverTheStepsThatAreSeen) {
  const double f = 4;
  for (const int per_period : {10, 13, 16})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Bench bench(clamped_chain(), rig_of(clamped_chain(), f), steady_drive(f), DrivenChain::Start::rest,
                  {.rate_hz = f * per_period, .sigma = {3e-8, 3e-8, 3e-8, 3e-4}}, seed);
      bench.alter = [](Record& record, double) {
        const double step = record.channel == 3 ? 5e-3 : 5e-7;
        record.value = step * std::round(record.value / step);
      };
      bench.run(40);
      bench.finish();
      ASSERT_EQ(bench.dwells.size(), 1u);
      expect_within(bench.dwells[0], clamped_chain(), 4.5, std::to_string(per_period) + " readings a period");
    }
}

TEST(Readings, OneBadReadingOfTheTableStopsNoDrive) {
  for (const double size : {0.004, 0.006}) {
    Bench bench(clamped_chain(), rig_of(clamped_chain(), 4), steady_drive(4), DrivenChain::Start::steady,
                {.rate_hz = 60, .sigma = {2e-6, 2e-6, 2e-6, 1e-2}});
    bool bad = false;
    bench.alter = [&](Record& record, double t) {
      if (record.channel != 0 || t < 20 || bad) return;
      record.value += size;
      bad = true;
    };
    bench.run(30);
    EXPECT_EQ(bench.pipeline.state(), State::measuring);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 1u) << size << ", ended by " << to_string(bench.dwells[0].ended_by) << " at "
                                       << bench.dwells[0].end_s;
    expect_within(bench.dwells[0], clamped_chain(), 4.5, std::to_string(size));
  }
}

TEST(Readings, HeldReadingsOfASlowDeviceStayWithinTheUncertainty) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 1000, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  // Noise of the device's own conversions, each read ten times: the noise repeats, the motion goes on.
  std::vector<double> held(4, 0.0);
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  int scan = 0;
  bench.alter = [&](Record& record, double) {
    if (record.channel == 0) ++scan;
    if (scan % 10 == 0) held[record.channel] = (record.channel == 3 ? 0.05 : 5e-6) * normal(rng);
    record.value += held[record.channel];
  };
  bench.run(60);
  expect_within(bench.pipeline.current(), chain, 4, "held");
}

TEST(Readings, EveryTransducerAndFilterIsDividedOut) {
  const Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4);
  rig.channels[1].measures = Quantity::velocity;
  rig.channels[2].measures = Quantity::acceleration;
  rig.channels[3].force_on_mass = true;
  rig.channels[1].scale = 0.5;
  rig.channels[1].offset = 3.0;
  Channel across = rig.channels[0];
  across.name = "d2";
  across.at = 2;
  across.relative_to = 1;
  rig.channels.push_back(across);
  Bench bench(chain, rig, steady_drive(4), DrivenChain::Start::steady, {.rate_hz = 200, .sigma = {}});
  bench.alter = [](Record& record, double) {
    if (record.channel == 1) record.value = (record.value - 3.0) / 0.5;
  };
  bench.run(10);
  bench.finish();
  ASSERT_EQ(bench.dwells.size(), 1u);
  expect_coefficients(bench.dwells[0], chain, 1e-6, 1e-5, "mixed transducers");
}

TEST(Readings, TransducersThatContradictEachOtherAreSaidTo) {
  const Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4);
  rig.channels.push_back(rig.channels[2]);
  rig.channels.back().name = "y2b";
  for (const bool wrong : {false, true}) {
    Bench bench(chain, rig, steady_drive(4), DrivenChain::Start::steady,
                {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01, 1e-6}});
    bench.alter = [&](Record& record, double) {
      if (record.channel == 4 && wrong) record.value *= 1.02;
    };
    bench.run(20);
    const Dwell dwell = bench.pipeline.current();
    const bool said = std::any_of(dwell.doubts.begin(), dwell.doubts.end(), [](const Doubt& doubt) {
      return doubt.what.find("y2 and y2b contradict") != std::string::npos;
    });
    EXPECT_EQ(said, wrong);
    if (!wrong) expect_within(dwell, chain, 4, "two transducers on one mass");
  }
}

TEST(Readings, HostileRecordsAreAllCounted) {
  const Chain chain = free_chain();
  Rig rig = rig_of(chain, 3);
  rig.channels[1].range.high = 1.0;
  Pipeline pipeline(rig);
  std::mt19937_64 rng(2);
  std::uint64_t sent = 0;
  for (int i = 0; i < 20000; ++i) {
    Record record;
    record.t_ns = static_cast<std::int64_t>(rng() % 4'000'000'000'000ULL);
    record.value = i % 3 ? std::ldexp(1.0, static_cast<int>(rng() % 2000) - 1000) : NAN;
    record.channel = static_cast<std::uint16_t>(rng() % 5);
    record.kind = static_cast<Kind>(rng() % 5);
    record.flags = static_cast<std::uint8_t>(rng() % 12);
    if (record.kind == Kind::sample && record.channel < 3) ++sent;
    pipeline.push(record);
  }
  pipeline.finish();
  std::uint64_t counted = 0;
  for (int c = 0; c < 3; ++c) counted += pipeline.channel(c).used + pipeline.channel(c).rejected;
  EXPECT_EQ(counted, sent);
}

// One reading in two thousand, twenty amplitudes off, would hide all that is left of a transient.
TEST(Readings, SpikesOfTheLoadCellAreLeftOutAndSaid) {
  std::mt19937_64 rng(8);
  for (int trial = 0; trial < 20; ++trial) {
    const double f = 4;
    const Chain chain = random_chain(rng, 1 + trial % 3, Boundary::clamped, f);
    const auto steady = steady_response(chain, 2 * M_PI * f, 0.002);
    Sampling sampling{.rate_hz = 160, .sigma = {}};
    for (const auto& y : steady.Y) sampling.sigma.push_back(2e-4 * std::abs(y));
    sampling.sigma.push_back(2e-4 * std::abs(steady.F));
    Bench bench(chain, rig_of(chain, f), steady_drive(f), DrivenChain::Start::rest, sampling,
                static_cast<std::uint64_t>(trial));
    const auto cell = static_cast<std::uint16_t>(chain.masses.size() + 1);
    std::uint64_t spikes = 0;
    bench.alter = [&](Record& record, double t) {
      if (record.channel != cell || rng() % 2000 != 0) return;
      record.value += 20 * std::abs(steady.F);
      if (t > 2 / f) ++spikes;  // before, nothing is known of the channel
    };
    const double patience_s = 10 + 12 / slowest_decay_rate(chain);
    bench.run(patience_s, [&] { return bench.pipeline.state() == State::measuring; });
    ASSERT_EQ(bench.pipeline.state(), State::measuring) << "trial " << trial;
    bench.run(bench.now_s() + 60);
    const Dwell dwell = bench.pipeline.current();
    EXPECT_EQ(dwell.index, 1) << "trial " << trial;
    EXPECT_EQ(bench.pipeline.channel(cell).rejected, spikes) << "trial " << trial;
    EXPECT_EQ(spikes > 0,
              std::any_of(dwell.warnings.begin(), dwell.warnings.end(),
                          [](const Warning& w) { return w.what.find("far from all other") != std::string::npos; }))
        << "trial " << trial;
    expect_within(dwell, chain, 4.5, "trial " + std::to_string(trial));
  }
}

// A step to nine times the amplitude is another motion: readings wait until that is clear, and none is lost.
TEST(Readings, WhatLastsIsNoSpike) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 160, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.alter = [](Record& record, double t) { record.value *= t < 10.05 ? 1.0 : 9.0; };
  bench.run(30);
  for (int c = 0; c < 4; ++c) EXPECT_EQ(bench.pipeline.channel(c).rejected, 0u) << "channel " << c;
  EXPECT_EQ(bench.dwells.size(), 1u);
  expect_within(bench.pipeline.current(), chain, 4, "after the step");
}

}  // namespace
}  // namespace dwell
