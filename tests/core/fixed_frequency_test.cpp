// reference = "fixed": what the rig file states of the drive's frequency is a prior, its stated uncertainty the width.
#include <gtest/gtest.h>

#include <cmath>

#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

struct Fixed {
  Chain chain = clamped_chain();
  double stated_hz = 4.0, true_hz = 4.0, frequency_u_hz = 0.0, clock_u = 5e-5;

  [[nodiscard]] Bench bench(std::uint64_t seed = 1) const {
    Rig rig = rig_of(chain, stated_hz);
    rig.excitation.reference = Reference::fixed;
    rig.excitation.frequency_u_hz = frequency_u_hz;
    rig.excitation.clock_u = clock_u;
    const SteadyResponse steady = steady_response(chain, 2 * M_PI * true_hz, 0.002);
    Sampling sampling{.rate_hz = 200, .sigma = {}};
    for (const Phasor& Y : steady.Y) sampling.sigma.push_back(1e-3 * std::abs(Y));
    if (chain.boundary == Boundary::clamped) sampling.sigma.push_back(1e-3 * std::abs(steady.F));
    return {chain, rig, steady_drive(true_hz), DrivenChain::Start::rest, sampling, seed};
  }
};

// Lightly damped, so that the verdict rests on the modes, and the drive itself must not be taken for one.
Chain lightly_damped() {
  Chain chain = clamped_chain();
  for (double& r : chain.damping) r *= 0.1;
  return chain;
}

TEST(FixedFrequency, ADriveOffByLessThanTheClockMayBeIsNoOscillationOfTheChain) {
  for (const Chain& chain : {clamped_chain(), lightly_damped()})
    for (const double off : {-1e-4, -4e-5, 4e-5, 1e-4})
      for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        Bench bench = Fixed{.chain = chain, .true_hz = 4.0 * (1 + off)}.bench(seed);
        bench.run(120);
        const Dwell dwell = bench.pipeline.current();
        const std::string what = std::to_string(1e6 * off) + " ppm, seed " + std::to_string(seed);
        ASSERT_EQ(dwell.state, State::measuring) << what << ": " << dwell.settling_reason;
        expect_within(dwell, chain, 4.5, what);
        EXPECT_NEAR(dwell.frequency_hz.value, 4.0 * (1 + off), 4 * dwell.frequency_hz.u) << what;
        for (std::size_t e = 0; e < chain.stiffness.size(); ++e)
          EXPECT_LT(dwell.elements[e].stiffness.U95, 0.01 * chain.stiffness[e]) << what;
      }
}

TEST(FixedFrequency, ItsStatedUncertaintyIsHowFarTheDataMayMoveIt) {
  const Fixed fixed{.true_hz = 4.01, .frequency_u_hz = 0.01};
  Bench bench = fixed.bench();
  bench.run(40);
  const Dwell dwell = bench.pipeline.current();
  ASSERT_EQ(dwell.state, State::measuring) << dwell.settling_reason;
  expect_within(dwell, fixed.chain, 4.5, "a hundredth of a hertz off");
  EXPECT_NEAR(dwell.frequency_hz.value, 4.01, 4 * dwell.frequency_hz.u);
  EXPECT_LT(dwell.frequency_hz.u, 0.001);
}

TEST(FixedFrequency, ADriveElsewhereIsNamedWithBothFiguresAndGivesNoCoefficients) {
  for (const double off : {-0.02, -1e-3, 5e-4, 2e-3}) {
    Bench bench = Fixed{.true_hz = 4.0 * (1 + off)}.bench();
    bench.run(60);
    const Dwell dwell = bench.pipeline.current();
    EXPECT_TRUE(dwell.elements.empty()) << off;
    const std::string begins = "the drive is at ";
    ASSERT_EQ(dwell.settling_reason.find(begins), 0u) << off << ": " << dwell.settling_reason;
    EXPECT_NEAR(std::stod(dwell.settling_reason.substr(begins.size())), 4.0 * (1 + off), 1e-4) << off;
    EXPECT_NE(dwell.settling_reason.find("fixed at 4"), std::string::npos) << off << ": " << dwell.settling_reason;
    EXPECT_TRUE(std::isnan(dwell.settles_in_s)) << off;
  }
}

TEST(FixedFrequency, OneThatIsStatedAsExactIsNotMoved) {
  Bench bench = Fixed{.clock_u = 0.0}.bench();
  bench.run(60);
  const Dwell dwell = bench.pipeline.current();
  ASSERT_EQ(dwell.state, State::measuring);
  EXPECT_EQ(dwell.frequency_hz.value, 4.0);
  EXPECT_EQ(dwell.frequency_hz.u, 0.0);
}

}  // namespace
}  // namespace dwell
