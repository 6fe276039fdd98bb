// The interlock and the sync input, as the pipeline heeds them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/dwell/pipeline.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

constexpr double kFrequency_hz = 4.03;

struct Inputs : testing::Test {
  // A drive within the range that is searched, not at the nominal frequency.
  void start(Reference reference = Reference::tracked, double noise = 1e-6) {
    rig = rig_of(chain, 4.0);
    rig.excitation.reference = reference;
    bench.emplace(chain, rig, steady_drive(kFrequency_hz), DrivenChain::Start::rest,
                  Sampling{.rate_hz = 160, .sigma = {noise, noise, noise, 1e4 * noise}});
    bench->alter = [this](Record& record, double) { pulses_until(record.t_ns); };
  }
  // One pulse for each period of the drive, at phase zero of the table.
  void pulses_until(std::int64_t t_ns) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> chance;
    for (; k / pulse_hz < 1e-9 * static_cast<double>(t_ns); ++k) {
      const double late_s = chance(rng) < 0.1 ? -stall_s * std::log(chance(rng)) : 0.0;
      const double due_s = k / pulse_hz + std::abs(jitter_s * normal(rng)) + std::min(late_s, 0.9 / pulse_hz);
      if (pulsing && chance(rng) >= missing)
        tell(Line::sync, true, std::min(std::llround(due_s * 1e9), static_cast<long long>(t_ns)));
    }
  }
  void tell(Line line, bool level, std::int64_t t_ns, std::uint8_t flags = 0) {
    Record record;
    record.kind = Kind::edge;
    record.channel = static_cast<std::uint16_t>(line);
    record.value = level ? 1.0 : 0.0;
    record.t_ns = t_ns;
    record.flags = flags;
    bench->push(record);
  }
  void interlock(bool level, std::uint8_t flags = 0) { tell(Line::interlock, level, last_ns(), flags); }
  [[nodiscard]] std::int64_t last_ns() const { return std::llround((bench->now_s() - 1.0 / 160) * 1e9); }
  [[nodiscard]] bool measuring() const { return bench->pipeline.state() == State::measuring; }
  void run(double for_s) { bench->run(bench->now_s() + for_s); }
  void expect_right(const Dwell& dwell) { expect_within(dwell, chain, 4, "inputs"); }

  Chain chain = clamped_chain();
  Rig rig;
  std::optional<Bench> bench;
  std::mt19937_64 rng{11};
  double pulse_hz = kFrequency_hz, jitter_s = 0.0, missing = 0.0;
  double stall_s = 0.0;  // by which, on average, one pulse in ten is late
  bool pulsing = true;
  double k = 0;
};

TEST_F(Inputs, TheLossOfTheInterlockEndsTheDwellAtOnceAndMarksIt) {
  start();
  interlock(true);
  run(20);
  ASSERT_TRUE(measuring());
  const double lost_s = bench->now_s();
  interlock(false);
  ASSERT_EQ(bench->dwells.size(), 1u);
  EXPECT_EQ(bench->dwells[0].ended_by, EndedBy::interlock);
  EXPECT_LE(bench->dwells[0].end_s, lost_s);
  EXPECT_GT(bench->dwells[0].end_s, lost_s - 2 / kFrequency_hz);
  expect_right(bench->dwells[0]);
  EXPECT_EQ(bench->pipeline.state(), State::idle);
  EXPECT_EQ(bench->pipeline.current().settling_reason, "the interlock is open");
}

TEST_F(Inputs, NothingIsMeasuredUntilTheInterlockReturnsAndNothingFromBeforeCounts) {
  start();
  interlock(true);
  run(20);
  interlock(false);
  run(20);
  EXPECT_EQ(bench->pipeline.state(), State::idle) << "though the table moves";
  EXPECT_TRUE(bench->pipeline.current().elements.empty());
  const double back_s = bench->now_s();
  interlock(true);
  run(15);
  ASSERT_TRUE(measuring());
  bench->finish();
  ASSERT_EQ(bench->dwells.size(), 2u);
  EXPECT_EQ(bench->dwells[1].index, 2);
  EXPECT_GE(bench->dwells[1].start_s, back_s - 1.0 / 160);
  expect_right(bench->dwells[1]);
}

TEST_F(Inputs, AnInterlockOpenFromTheStartKeepsTheRigIdle) {
  start();
  interlock(false);
  run(20);
  EXPECT_EQ(bench->pipeline.state(), State::idle);
  EXPECT_TRUE(bench->dwells.empty());
}

TEST_F(Inputs, AnInterlockOfWhichEdgesWereLostMayHaveBeenOpen) {
  start();
  interlock(true);
  run(20);
  interlock(true);
  EXPECT_TRUE(measuring()) << "told once more";
  interlock(true, kGap);
  ASSERT_EQ(bench->dwells.size(), 1u);
  EXPECT_EQ(bench->dwells[0].ended_by, EndedBy::interlock);
  run(15);
  EXPECT_TRUE(measuring());
}

TEST_F(Inputs, ADriveThatTheInterlockHasCutIsMarkedSo) {
  start();
  interlock(true);
  run(20);
  Drive less;
  less.frequency_hz = kFrequency_hz;
  less.amplitude = 0.001;
  bench->set_drive(less);
  run(0.45);
  ASSERT_EQ(bench->pipeline.state(), State::settling) << "the motion has told already that the drive is another";
  ASSERT_TRUE(bench->dwells.empty()) << "but not yet whether it stops";
  interlock(false);
  run(5);
  ASSERT_EQ(bench->dwells.size(), 1u);
  EXPECT_EQ(bench->dwells[0].ended_by, EndedBy::interlock);
}

TEST_F(Inputs, PulsesGiveTheFrequencyAndItsUncertaintyAndThePhase) {
  jitter_s = 2e-4;
  missing = 0.05;
  start(Reference::sync);
  run(60);
  ASSERT_TRUE(measuring()) << bench->pipeline.current().settling_reason;
  const Dwell dwell = bench->pipeline.current();
  EXPECT_LT(std::abs(dwell.frequency_hz.value - kFrequency_hz), 4 * dwell.frequency_hz.u);
  EXPECT_GT(dwell.frequency_hz.u, 1e-7);
  EXPECT_LT(dwell.frequency_hz.u, 1e-5);
  expect_right(dwell);
  // The table is at phase zero with the pulses, but for these being late by what they jitter.
  EXPECT_NEAR(std::arg(dwell.phasors[0].Y), 0.0, 2e-4 * 2 * M_PI * kFrequency_hz);
  const double periods = dwell.t_ref_s * kFrequency_hz;
  EXPECT_NEAR(periods, std::round(periods), 2e-3);
  ASSERT_FALSE(dwell.warnings.empty());
  EXPECT_NE(dwell.warnings.back().what.find("missed"), std::string::npos);
}

// By 2ω Σ m_i Y_i / d_1 δω, and by what residuals at a frequency a little off no longer are: white.
TEST_F(Inputs, TheUncertaintyOfThePulsesEntersTheCoefficients) {
  start(Reference::sync);
  run(20);
  const double sure = bench->pipeline.current().elements.at(0).stiffness.u;
  k = 0;
  jitter_s = 0.01;
  start(Reference::sync);
  run(20);
  const Dwell dwell = bench->pipeline.current();
  ASSERT_EQ(dwell.elements.size(), 3u);
  const ElementEstimate& first = dwell.elements[0];
  EXPECT_GT(first.stiffness.u, 2 * sure);
  const double omega = 2 * M_PI * kFrequency_hz;
  const auto Y = steady_response(chain, omega, 0.002).Y;
  const double slope =
      (2 * omega * (chain.masses[0] * Y[1] + chain.masses[1] * Y[2]) / (Y[1] - Y[0])).real();  // N/m per rad/s
  const auto share = std::find_if(first.budget.begin(), first.budget.end(),
                                  [](const BudgetShare& each) { return each.source == "frequency"; });
  ASSERT_NE(share, first.budget.end());
  const double expected = std::abs(slope) * 2 * M_PI * dwell.frequency_hz.u;
  EXPECT_NEAR(std::sqrt(share->stiffness_share) * first.stiffness.u, expected, 0.01 * expected);
  expect_right(dwell);
}

TEST_F(Inputs, PulsesOfABusyMachineThatAreLateNowAndThenEndNoDwell) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    rng.seed(seed);
    k = 0;
    jitter_s = 1e-3;
    stall_s = 0.03;
    start(Reference::sync, 5e-6);
    run(120);
    EXPECT_TRUE(measuring());
    EXPECT_TRUE(bench->dwells.empty()) << "seed " << seed;
    expect_right(bench->pipeline.current());
  }
}

TEST_F(Inputs, WithoutPulsesThereIsNoNumberButAReason) {
  pulsing = false;
  start(Reference::sync);
  run(20);
  EXPECT_EQ(bench->pipeline.state(), State::fault);
  EXPECT_NE(bench->pipeline.current().settling_reason.find("no sync pulse seen"), std::string::npos);
  EXPECT_TRUE(std::isnan(bench->pipeline.current().frequency_hz.value));
  pulsing = true;
  run(20);
  EXPECT_TRUE(measuring());
  pulsing = false;
  run(8 / kFrequency_hz + 1);
  EXPECT_EQ(bench->pipeline.state(), State::fault);
  ASSERT_EQ(bench->dwells.size(), 1u);
  EXPECT_EQ(bench->dwells[0].ended_by, EndedBy::data_lost);
  expect_right(bench->dwells[0]);
  EXPECT_NE(bench->pipeline.current().settling_reason.find("no sync pulse for"), std::string::npos);
  EXPECT_TRUE(bench->pipeline.current().elements.empty());
  pulsing = true;
  run(20);
  EXPECT_TRUE(measuring());
}

TEST_F(Inputs, PulsesOfAnotherFrequencyThanTheTablesGiveNoNumber) {
  pulse_hz = 3.95;
  start(Reference::sync);
  run(30);
  EXPECT_EQ(bench->pipeline.state(), State::settling);
  EXPECT_TRUE(bench->dwells.empty());
  EXPECT_NE(bench->pipeline.current().settling_reason.find("the table moves at 4.03"), std::string::npos)
      << bench->pipeline.current().settling_reason;
}

TEST_F(Inputs, PulsesThatAreAlmostThoseOfTheTableGiveNoWrongNumber) {
  for (const double off : {0.0005, 0.001, 0.003, -0.006}) {
    pulse_hz = kFrequency_hz * (1 + off);
    k = 0;
    start(Reference::sync);
    for (int second = 0; second < 60; ++second) {
      run(1);
      const Dwell dwell = bench->pipeline.current();
      if (!dwell.elements.empty()) expect_right(dwell);
    }
    for (const Dwell& dwell : bench->dwells)
      if (!dwell.elements.empty()) expect_right(dwell);
    const Dwell dwell = bench->pipeline.current();
    if (std::abs(off) < 0.003) continue;
    EXPECT_TRUE(dwell.elements.empty()) << off;
    EXPECT_NE(dwell.settling_reason.find("sync pulses"), std::string::npos) << dwell.settling_reason;
  }
}

TEST_F(Inputs, WhereTheMotionGivesTheFrequencyPulsesChangeNothing) {
  start();
  run(20);
  const Dwell with = bench->pipeline.current();
  k = 0;
  pulsing = false;
  start();
  run(20);
  const Dwell without = bench->pipeline.current();
  EXPECT_EQ(with.frequency_hz.value, without.frequency_hz.value);
  EXPECT_EQ(with.elements[0].stiffness.value, without.elements[0].stiffness.value);
}

TEST_F(Inputs, TheSameStreamGivesTheSameBits) {
  double first = 0.0;
  for (int i = 0; i < 2; ++i) {
    rng.seed(11);
    k = 0;
    jitter_s = 2e-4;
    missing = 0.1;
    start(Reference::sync);
    interlock(true);
    run(20);
    interlock(false);
    const double c = bench->dwells.at(0).elements.at(1).stiffness.value;
    if (i == 0) first = c;
    EXPECT_EQ(c, first);
  }
}

}  // namespace
}  // namespace dwell
