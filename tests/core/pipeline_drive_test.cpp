// The drive changes, stops, or is elsewhere: where a dwell ends, and what is said of it.
#include <gtest/gtest.h>

#include "core/dwell/pipeline.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

TEST(Pipeline, RearmsByItselfWhenTheDriveChangesAndIsIdleWhenItStops) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::rest,
              {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  EXPECT_EQ(bench.pipeline.state(), State::idle);
  const auto measuring = [&] { return bench.pipeline.state() == State::measuring; };
  bench.run(60, measuring);
  ASSERT_TRUE(measuring());
  bench.run(bench.now_s() + 5);

  bench.set_drive(steady_drive(4, 0.003));
  const double stepped = bench.now_s();
  bench.run(stepped + 0.5);  // two periods
  EXPECT_EQ(bench.pipeline.state(), State::settling);
  bench.run(stepped + 1.25);  // by then it is known that the drive has changed and does not stop
  ASSERT_EQ(bench.dwells.size(), 1u);
  EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::drive_changed);
  EXPECT_LE(bench.dwells[0].end_s, stepped);
  expect_within(bench.dwells[0], chain, 4, "before the amplitude step");

  bench.run(120, measuring);
  bench.run(bench.now_s() + 5);
  bench.set_drive(steady_drive(4.07, 0.003));
  bench.run(bench.now_s() + 2 / 4.07);
  EXPECT_EQ(bench.pipeline.state(), State::settling);
  bench.run(bench.now_s() + 4 / 4.07);
  ASSERT_EQ(bench.dwells.size(), 2u);
  expect_within(bench.dwells[1], chain, 4, "before the frequency step");
  bench.run(180, measuring);
  ASSERT_TRUE(measuring());
  bench.run(bench.now_s() + 5);
  expect_within(bench.pipeline.current(), chain, 4, "after the frequency step");

  bench.set_drive(steady_drive(4.07, 0.0));
  bench.run(bench.now_s() + 3 / 4.07);
  EXPECT_EQ(bench.pipeline.state(), State::idle);
  ASSERT_EQ(bench.dwells.size(), 3u);
  EXPECT_EQ(bench.dwells[2].ended_by, EndedBy::drive_stopped);
  EXPECT_FALSE(bench.pipeline.current().index.has_value());
}

TEST(Pipeline, AFrequencyAThousandthOffEndsTheDwellBeforeItMixesTheTwo) {
  const Chain chain = clamped_chain();
  Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.run(30);
  bench.set_drive(steady_drive(4.004));
  bench.run(60);
  bench.finish();
  ASSERT_EQ(bench.dwells.size(), 2u);
  EXPECT_NEAR(bench.dwells[0].frequency_hz.value, 4.0, 1e-4);
  EXPECT_NEAR(bench.dwells[1].frequency_hz.value, 4.004, 1e-4);
}

TEST(Pipeline, AStopIsToldAsAStopHoweverItFallsAndLosesNothing) {
  const Chain chain = clamped_chain();
  for (const double ramp_s : {0.0, 0.1, 0.15, 0.2, 0.5, 1.5})
    for (int phase = 0; phase < 8; ++phase) {
      Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
                  {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
      bench.run(10 + phase / 32.0);
      Drive off = steady_drive(4, 0.0);
      off.ramp_s = ramp_s;
      bench.set_drive(off);
      bench.run(20);
      ASSERT_EQ(bench.dwells.size(), 1u) << "ramp " << ramp_s << " phase " << phase;
      EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::drive_stopped);
      EXPECT_LE(bench.dwells[0].end_s, 10 + phase / 32.0 + 0.01);
      expect_within(bench.dwells[0], chain, 4.5, "before the stop");
      EXPECT_EQ(bench.pipeline.state(), State::idle);
    }
}

TEST(Pipeline, NoiseAloneIsNoDwell) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 3), steady_drive(3, 0.0), DrivenChain::Start::rest,
              {.rate_hz = 100, .sigma = {1e-5, 1e-5, 1e-5}});
  bench.run(1200);
  bench.finish();
  EXPECT_EQ(bench.dwells.size(), 0u);
}

TEST(Pipeline, HarmonicsOfTheDriveThatAreNotFittedAreNoTransient) {
  Drive drive = steady_drive(4);
  drive.harmonics = {{5, 1e-5, 0.0}};
  Bench bench(clamped_chain(), rig_of(clamped_chain(), 4), drive, DrivenChain::Start::rest,
              {.rate_hz = 200, .sigma = {2e-7, 2e-7, 2e-7, 2e-3}});
  bench.run(20, [&] { return bench.pipeline.state() == State::measuring; });
  EXPECT_EQ(bench.pipeline.state(), State::measuring) << bench.pipeline.current().settling_reason;
}

TEST(Pipeline, OutsideTheSearchNothingIsShownButWhereTheDriveIs) {
  const Chain chain = free_chain();
  Rig rig = rig_of(chain, 3);
  rig.excitation.search_low_hz = 2.8;
  rig.excitation.search_high_hz = 3.2;
  Bench bench(chain, rig, steady_drive(3.3), DrivenChain::Start::steady, {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  bench.run(20);
  const Dwell dwell = bench.pipeline.current();
  EXPECT_NE(dwell.settling_reason.find("outside the search range"), std::string::npos) << dwell.settling_reason;
  EXPECT_TRUE(std::isnan(dwell.frequency_hz.value));
  for (const ChannelPhasor& phasor : dwell.phasors) EXPECT_FALSE(phasor.reason.empty());
}

}  // namespace
}  // namespace dwell
