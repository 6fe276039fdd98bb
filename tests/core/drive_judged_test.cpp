// When the drive is another one, from when on, and what is said of a drive that gives no dwell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/model/forward.hpp"
#include "tests/core/expect.hpp"
#include "tests/core/tones.hpp"

namespace dwell {
namespace {

Sampling with_noise(const Chain& chain, double hz, double rate_hz, double of_table, double of_others) {
  const SteadyResponse steady = steady_response(chain, 2 * M_PI * hz, 0.002);
  Sampling sampling{.rate_hz = rate_hz, .sigma = {}};
  for (const Phasor& Y : steady.Y)
    sampling.sigma.push_back((sampling.sigma.empty() ? of_table : of_others) * std::abs(Y));
  if (chain.boundary == Boundary::clamped) sampling.sigma.push_back(of_others * std::abs(steady.F));
  return sampling;
}

// A step that the noise hides for long is seen late. What came after it is no part of the dwell.
TEST(DriveJudged, AStepThatIsSeenLateIsTakenBackToWhereItWas) {
  const Chain chain = clamped_chain();
  const double hz = 10;
  int seen_late = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Bench bench(chain, rig_of(chain, hz), steady_drive(hz), DrivenChain::Start::steady,
                with_noise(chain, hz, 160, 0.045, 1e-3), seed);
    bench.run(60);
    ASSERT_EQ(bench.pipeline.state(), State::measuring);
    bench.set_drive(steady_drive(hz, 0.002 * 1.0095));
    bench.run(100, [&] { return !bench.dwells.empty(); });
    bench.run(bench.now_s() + 30, [&] { return !bench.dwells.empty(); });
    ASSERT_EQ(bench.dwells.size(), 1u) << seed;
    seen_late += bench.now_s() > 60 + 20 / hz;
    // Or as far as the watch remembers, 128 periods.
    EXPECT_LE(bench.dwells[0].end_s, std::max(60 + 12 / hz, bench.now_s() - 115 / hz))
        << seed << ", seen at " << bench.now_s();
  }
  EXPECT_GE(seen_late, 2);
}

TEST(DriveJudged, TheResultDoesNotDependOnWhereTheTimeAxisBegins) {
  const Chain chain = clamped_chain();
  double verdict_s[2] = {}, u[2] = {};
  for (const bool negative : {false, true}) {
    Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::rest,
                with_noise(chain, 4, 200, 1e-3, 1e-3));
    if (negative) bench.alter = [](Record& record, double) { record.t_ns -= 100'000'000'000; };
    bench.run(30);
    const Dwell dwell = bench.pipeline.current();
    ASSERT_EQ(dwell.state, State::measuring);
    verdict_s[negative] = dwell.verdict_s;
    u[negative] = dwell.elements[0].damping.u;
  }
  EXPECT_NEAR(verdict_s[1], verdict_s[0], 1e-6);
  EXPECT_NEAR(u[1] / u[0], 1.0, 1e-3);
}

// With few readings a period the noise of one window is itself uncertain: that of the dwell is known.
TEST(DriveJudged, ANoisyTableAloneEndsNoDwell) {
  const Chain chain = clamped_chain();
  int ended = 0;
  for (const double rate_hz : {37.0, 50.0})
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Bench bench(chain, rig_of(chain, 4.02), steady_drive(4), DrivenChain::Start::rest,
                  with_noise(chain, 4, rate_hz, 0.1, 1e-3), seed);
      bench.run(60);
      for (const Dwell& dwell : bench.dwells) ended += dwell.ended_by == EndedBy::drive_changed;
    }
  EXPECT_EQ(ended, 0);
}

TEST(DriveJudged, NoTimeLeftIsToldWhereAnotherReasonBars) {
  const Chain chain = free_chain();
  Rig rig = rig_of(chain, 3);
  rig.excitation.search_low_hz = 2.8;
  rig.excitation.search_high_hz = 3.2;
  Bench bench(chain, rig, steady_drive(3.3), DrivenChain::Start::rest, with_noise(chain, 3, 100, 1e-3, 1e-3));
  for (int i = 1; i <= 80; ++i) {
    bench.run(i / 4.0);
    const Dwell dwell = bench.pipeline.current();
    if (dwell.settling_reason.find("outside the search range") == std::string::npos) continue;
    ASSERT_TRUE(std::isnan(dwell.settles_in_s)) << i / 4.0 << " s: " << dwell.settles_in_s;
    ASSERT_NE(dwell.settling_reason.find("3.3"), std::string::npos) << dwell.settling_reason;
    ASSERT_NE(dwell.settling_reason.find("2.8 to 3.2 Hz"), std::string::npos) << dwell.settling_reason;
  }
  EXPECT_NE(bench.pipeline.current().settling_reason.find("outside the search range"), std::string::npos);
}

// Six millimetres for half a minute are not "the table does not move".
TEST(DriveJudged, ATableThatIsNeverSteadyIsDescribedByWhatItDid) {
  const Chain chain = clamped_chain();
  Toned toned{.chain = chain, .rig = rig_of(chain, 4.0), .tones = hunting(4.0, 0.006, 0.11, 1.3)};
  Pipeline pipeline(toned.rig);
  std::vector<Dwell> dwells;
  toned.play(pipeline, 30, [&](std::uint8_t changes) {
    if (changes & kCompleted) dwells.push_back(pipeline.completed());
  });
  const std::string live = pipeline.current().settling_reason;
  for (const char* part : {"the table moves by", "mm at ", "Hz", "between", "tolerance"})
    EXPECT_NE(live.find(part), std::string::npos) << part << ": " << live;
  // And once it has stopped, the recording holds a dwell that did not settle, with that reason.
  toned.tones = {{4.0, 1e-9}};
  toned.play(pipeline, 5, [&](std::uint8_t changes) {
    if (changes & kCompleted) dwells.push_back(pipeline.completed());
  });
  ASSERT_FALSE(dwells.empty());
  EXPECT_FALSE(std::isfinite(dwells.back().settled_s));
  EXPECT_NE(dwells.back().settling_reason.find("the table moves by"), std::string::npos)
      << dwells.back().settling_reason;
}

TEST(DriveJudged, ATableThatHardlyMovesIsToldWithItsAmplitude) {
  const Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4);
  rig.excitation.minimum = 1e-3;
  Bench bench(chain, rig, steady_drive(4, 0.0002), DrivenChain::Start::steady, with_noise(chain, 4, 100, 1e-4, 1e-4));
  bench.run(10);
  const std::string reason = bench.pipeline.current().settling_reason;
  EXPECT_NE(reason.find("0.2"), std::string::npos) << reason;
  EXPECT_NE(reason.find("minimum"), std::string::npos) << reason;
}

}  // namespace
}  // namespace dwell
