// A steady drive: coefficients within their uncertainty, and the same bits each time.
#include "core/dwell/pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

TEST(Pipeline, NoiseFreeRecordingsBegunInTheSteadyStateGiveTheCoefficientsExactly) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 40; ++trial) {
    const double f = 2 + trial % 7;
    const Boundary boundary = trial % 2 ? Boundary::clamped : Boundary::free;
    const Chain chain = random_chain(rng, 1 + trial % 5, boundary, f);
    // The nominal frequency is as much as 1.5 % off: it is refined from the motion.
    Bench bench(chain, rig_of(chain, f * (1 + 0.005 * (trial % 7 - 3))), steady_drive(f), DrivenChain::Start::steady,
                {.rate_hz = 40 * f, .sigma = {}});
    bench.run(30 / f);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 1u);
    // The first period is left to what was before; where the frequency is not as stated, another may be spent on it.
    EXPECT_LE(bench.dwells[0].settled_s, (trial % 7 == 3 ? 1.001 : 2.5) / f);
    expect_coefficients(bench.dwells[0], chain, 1e-6, 1e-5, "trial " + std::to_string(trial));
    EXPECT_NEAR(bench.dwells[0].frequency_hz.value / f, 1.0, 1e-7);
  }
}

TEST(Pipeline, WarnsOfHumThatNothingCanTellFromAHarmonic) {
  for (const double f : {10.0, 11.3}) {  // 50 Hz lies on the fifth harmonic, or between the fourth and the fifth
    Rig rig = rig_of(free_chain(), f);
    rig.excitation.harmonics = 5;
    Bench bench(free_chain(), rig, steady_drive(f), DrivenChain::Start::steady, {.rate_hz = 400, .sigma = {}});
    bench.run(5);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 1u);
    const auto& warnings = bench.dwells[0].warnings;
    EXPECT_EQ(std::any_of(warnings.begin(), warnings.end(),
                          [](const Warning& w) { return w.what.find("hum of 50 Hz") != std::string::npos; }),
              f == 10.0);
  }
}

TEST(Pipeline, HoldsFromRestUntilTheTransientHasDecayedAndThenIsWithinItsUncertainty) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 40; ++trial) {
    const double f = 4;
    const Chain chain = random_chain(rng, 1 + trial % 4, trial % 2 ? Boundary::clamped : Boundary::free, f);
    const Rig rig = rig_of(chain, f);
    const auto steady = steady_response(chain, 2 * M_PI * f, 0.002);
    Sampling sampling{.rate_hz = 160, .sigma = {}};
    for (const auto& y : steady.Y) sampling.sigma.push_back(2e-3 * std::abs(y));
    if (chain.boundary == Boundary::clamped) sampling.sigma.push_back(2e-3 * std::abs(steady.F));
    Bench bench(chain, rig, steady_drive(f), DrivenChain::Start::rest, sampling, static_cast<std::uint64_t>(trial));
    bench.run(60, [&] { return bench.pipeline.state() == State::measuring; });
    ASSERT_EQ(bench.pipeline.state(), State::measuring) << "trial " << trial;
    const double verdict = bench.now_s();
    // What is left of the transient at the verdict, against the exact response.
    const double T = 1 / slowest_decay_rate(chain);
    EXPECT_GT(verdict, 0.3 * T) << "trial " << trial;
    bench.run(verdict + 30);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 1u);
    // 40 trials of up to 10 numbers: 4.5 u is passed by chance once in 400 runs of this test; the seed is fixed.
    expect_within(bench.dwells[0], chain, 4.5, "trial " + std::to_string(trial));
  }
}

// The frequency is then better told by the masses, and a natural oscillation beside it must not take its place.
TEST(Pipeline, ATableFarNoisierThanTheMassesHoldsNoVerdictUp) {
  std::mt19937_64 rng(11);
  for (int trial = 0; trial < 20; ++trial) {
    const double f = 4;
    const Chain chain = random_chain(rng, 1 + trial % 3, trial % 2 ? Boundary::clamped : Boundary::free, f);
    const auto steady = steady_response(chain, 2 * M_PI * f, 0.002);
    Sampling sampling{.rate_hz = 50, .sigma = {}};
    for (const auto& y : steady.Y) sampling.sigma.push_back((sampling.sigma.empty() ? 2e-2 : 2e-4) * std::abs(y));
    if (chain.boundary == Boundary::clamped) sampling.sigma.push_back(2e-4 * std::abs(steady.F));
    Bench bench(chain, rig_of(chain, 1.01 * f), steady_drive(f), DrivenChain::Start::rest, sampling,
                static_cast<std::uint64_t>(trial));
    bench.run(30 + 10 / slowest_decay_rate(chain), [&] { return bench.pipeline.state() == State::measuring; });
    ASSERT_EQ(bench.pipeline.state(), State::measuring)
        << "trial " << trial << ": " << bench.pipeline.current().settling_reason;
    bench.run(bench.now_s() + 30);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 1u) << "trial " << trial;
    expect_within(bench.dwells[0], chain, 4.5, "trial " + std::to_string(trial));
  }
}

TEST(Pipeline, SkewedAndJitteredChannelsGiveTheSameWithinTheirUncertainty) {
  const Chain chain = clamped_chain();
  const double f = 4;
  const Rig rig = rig_of(chain, f);
  const Sampling skewed{.rate_hz = 100, .skew_s = 0.005 / 3, .jitter = 0.1, .sigma = {2e-6, 2e-6, 2e-6, 0.02}};
  Bench bench(chain, rig, steady_drive(f), DrivenChain::Start::steady, skewed);
  bench.run(20);
  bench.finish();
  ASSERT_EQ(bench.dwells.size(), 1u);
  expect_within(bench.dwells[0], chain, 4, "own instants");

  // The same readings stamped as if taken at once: the damping is far off. The jitter betrays the stamps, and the
  // uncertainty covers the skew; before, r was off by more than 50 u.
  Sampling wrong = skewed;
  wrong.stamps_as_simultaneous = true;
  Bench simultaneous(chain, rig, steady_drive(f), DrivenChain::Start::steady, wrong);
  simultaneous.run(60);  // the jitter looks like noise, which takes longer to be told from a transient
  simultaneous.finish();
  ASSERT_EQ(simultaneous.dwells.size(), 1u);
  ASSERT_EQ(simultaneous.dwells[0].elements.size(), 3u);
  double farthest = 0.0;
  for (std::size_t e = 0; e < 3; ++e) {
    const Coefficient& r = simultaneous.dwells[0].elements[e].damping;
    farthest = std::max(farthest, std::abs(r.value / chain.damping[e] - 1));
    EXPECT_LT(std::abs(r.value - chain.damping[e]), 4 * r.u);
  }
  EXPECT_GT(farthest, 0.1);
  const auto named = [](const Warning& warning) {
    return warning.what.find("scatter most where it moves fastest") != std::string::npos;
  };
  EXPECT_TRUE(std::any_of(simultaneous.dwells[0].warnings.begin(), simultaneous.dwells[0].warnings.end(), named));
}

TEST(Pipeline, TheSameStreamFedTwiceGivesTheSameBits) {
  const Chain chain = free_chain();
  const auto run = [&] {
    Bench bench(chain, rig_of(chain, 3), steady_drive(3), DrivenChain::Start::rest,
                {.rate_hz = 97, .skew_s = 0.001, .jitter = 0.1, .sigma = {1e-6, 1e-6, 1e-6}}, 9);
    bench.run(40);
    bench.finish();
    return bench.dwells;
  };
  const auto first = run(), second = run();
  ASSERT_EQ(first.size(), 1u);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t e = 0; e < first[0].elements.size(); ++e) {
    EXPECT_EQ(first[0].elements[e].stiffness.value, second[0].elements[e].stiffness.value);
    EXPECT_EQ(first[0].elements[e].damping.u, second[0].elements[e].damping.u);
  }
  EXPECT_EQ(first[0].covariance, second[0].covariance);
}

// Every mode is gone before the fit begins: nothing is left to wait for.
TEST(Pipeline, AStiffRigFarBelowItsModesSettles) {
  const double f = 2, natural = 2 * M_PI * 60;
  const Chain chain{
      Boundary::clamped, {10.0}, {5 * natural * natural, 5 * natural * natural}, {1.5 * natural, 1.5 * natural}};
  const Rig rig = rig_of(chain, f);
  const auto steady = steady_response(chain, 2 * M_PI * f, 0.002);
  Sampling sampling{.rate_hz = 7 * f, .skew_s = 0.003, .jitter = 0.1, .sigma = {}};
  for (const Phasor& Y : steady.Y) sampling.sigma.push_back(1e-3 * std::abs(Y));
  sampling.sigma.push_back(1e-3 * std::abs(steady.F));
  Rig few = rig;
  few.excitation.harmonics = 2;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Drive drive = steady_drive(f);
    drive.ramp_s = 1.7;
    Bench bench(chain, few, drive, DrivenChain::Start::rest, sampling, seed);
    bench.run(30 / f);
    EXPECT_EQ(bench.pipeline.state(), State::measuring) << bench.pipeline.current().settling_reason;
  }
}

TEST(Pipeline, NamesWhatSwingsBesideDriveAndChain) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 3), steady_drive(3), DrivenChain::Start::steady,
              {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  bench.alter = [](Record& record, double t) {
    if (record.channel > 0) record.value += 2e-4 * std::sin(2 * M_PI * 7.3 * t);
  };
  bench.run(10);
  ASSERT_EQ(bench.pipeline.state(), State::settling);
  EXPECT_NE(bench.pipeline.current().settling_reason.find("an oscillation that is not the chain's, at 7.3"),
            std::string::npos)
      << bench.pipeline.current().settling_reason;
}

TEST(Pipeline, GivesAmplitudeAndPhaseAtEverySample) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 3), steady_drive(3), DrivenChain::Start::steady, {.rate_hz = 100, .sigma = {}});
  bench.run(0.5);
  for (int i = 0; i < 400; ++i) {
    bench.run(bench.now_s() + 0.01);
    // The newest sample is one interval before the next.
    const double phase = 2 * M_PI * 3 * (bench.now_s() - 0.01);
    const std::complex<double> Y = bench.pipeline.phasor(0);
    ASSERT_NEAR(std::abs(Y), 0.002, 1e-8);
    ASSERT_NEAR(std::remainder(std::arg(Y) - phase, 2 * M_PI), 0.0, 1e-5);
  }
}

}  // namespace
}  // namespace dwell
