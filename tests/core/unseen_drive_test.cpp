// A drive that its channel does not show: stuck, or at rest with readings that are all the same.
#include <gtest/gtest.h>

#include <cmath>

#include "core/dwell/pipeline.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

Bench measuring_bench(const Chain& chain) {
  return Bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
               {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
}

// It was measured on, at the old frequency, for as long as the reading stood still.
TEST(UnseenDrive, AStuckDriveChannelEndsTheDwellAsLostWhateverTheTableDoes) {
  const Chain chain = clamped_chain();
  Bench bench = measuring_bench(chain);
  bench.run(20);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  bench.alter = [](Record& record, double) {
    if (record.channel == 0) record.value = 1.234e-3;
  };
  bench.set_drive(steady_drive(4.05));
  bench.run(22);
  EXPECT_EQ(bench.pipeline.state(), State::fault);
  ASSERT_EQ(bench.dwells.size(), 1U);
  EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::data_lost);
  EXPECT_EQ(bench.dwells[0].elements[0].reason, "y0: stuck at one reading");
  EXPECT_TRUE(bench.dwells[0].elements[1].identifiable);
  const Dwell unseen = bench.pipeline.current();
  EXPECT_EQ(unseen.settling_reason.find("the drive is not seen: y0 is stuck at one reading for 1."), 0U)
      << unseen.settling_reason;
  bench.alter = nullptr;
  bench.run(60);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  EXPECT_NEAR(bench.pipeline.current().frequency_hz.value, 4.05, 1e-3);
}

// An encoder of a table at rest reads one and the same value: that is no fault of it.
TEST(UnseenDrive, ATableThatStopsWithinAStepOfItsEncoderIsAtRest) {
  const Chain chain = clamped_chain();
  for (const double step : {1e-9, 1e-6, 1e-5})
    for (const double ramp_s : {0.0, 0.1, 0.5}) {
      Bench bench(chain, rig_of(chain, 4), steady_drive(4), DrivenChain::Start::steady,
                  {.rate_hz = 200, .sigma = {0, 1e-6, 1e-6, 0.01}});
      bench.alter = [step](Record& record, double) {
        if (record.channel == 0) record.value = step * std::round(record.value / step);
      };
      bench.run(20);
      Drive off = steady_drive(4, 0.0);
      off.ramp_s = ramp_s;
      bench.set_drive(off);
      bench.run(40);
      EXPECT_EQ(bench.pipeline.state(), State::idle)
          << step << ' ' << ramp_s << ' ' << bench.pipeline.current().settling_reason;
      ASSERT_EQ(bench.dwells.size(), 1U);
      EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::drive_stopped) << step << ' ' << ramp_s;
      bench.set_drive(steady_drive(4));
      bench.run(80);
      EXPECT_EQ(bench.pipeline.state(), State::measuring) << step << ' ' << ramp_s;
    }
}

TEST(UnseenDrive, AChannelThatReadsTheSameAllTheTimeMayBeStuckAndIsNotCalledARestingTable) {
  const Chain chain = clamped_chain();
  Bench bench = measuring_bench(chain);
  bench.alter = [](Record& record, double) {
    if (record.channel == 0) record.value = 1.234e-3;
  };
  bench.run(10);
  EXPECT_NE(
      bench.pipeline.current().settling_reason.find("the table does not move, or y0 is stuck at one reading for 9."),
      std::string::npos)
      << bench.pipeline.current().settling_reason;
}

TEST(UnseenDrive, NothingReadBeforeARearmCountsAfterIt) {
  const Chain chain = clamped_chain();
  Bench bench = measuring_bench(chain);
  for (const double at_s : {20.01, 40.13, 60.24}) {
    bench.run(at_s);
    ASSERT_EQ(bench.pipeline.state(), State::measuring);
    bench.push({.t_ns = std::llround(bench.now_s() * 1e9),
                .kind = Kind::action,
                .flags = static_cast<std::uint8_t>(Action::rearm)});
    const double rearmed_s = bench.now_s();
    bench.run(at_s + 15);
    const Dwell next = bench.pipeline.current();
    ASSERT_EQ(next.state, State::measuring);
    EXPECT_GE(next.start_s, rearmed_s);
    EXPECT_GE(next.settled_s, rearmed_s);
  }
}

}  // namespace
}  // namespace dwell
