// What of a dwell counts: its memory, an operator's new beginning, an element that changes within it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/dwell/pipeline.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

TEST(Pipeline, AnElementThatChangesWithinTheDwellIsNotReportedAsIfItHadNot) {
  Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4);
  Bench bench(chain, rig, steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 200, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.run(20);
  bench.alter = [](Record& record, double) {
    if (record.channel == 2) record.value *= 0.95;  // a transducer's gain, seen as a change of its elements
  };
  bench.run(40);
  const Dwell dwell = bench.pipeline.current();
  EXPECT_TRUE(std::any_of(dwell.warnings.begin(), dwell.warnings.end(),
                          [](const Warning& w) { return w.what.find("y2 is not steady") == 0; }));
  // Twelve stretches, half of them off by d/2 either way: their spread is d/2, as the error is.
  EXPECT_LT(std::abs(dwell.elements[2].stiffness.value - chain.stiffness[2]), 2 * dwell.elements[2].stiffness.u);
}

TEST(Pipeline, ADwellThatAnOperatorBeginsAnewSaysSo) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 3), steady_drive(3), DrivenChain::Start::steady,
              {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  bench.run(30);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  Record rearm;
  rearm.t_ns = std::llround(bench.now_s() * 1e9);
  rearm.kind = Kind::action;
  rearm.flags = static_cast<std::uint16_t>(Action::rearm);
  bench.push(rearm);
  ASSERT_EQ(bench.dwells.size(), 1u);
  EXPECT_STREQ(to_string(bench.dwells[0].ended_by), "re-armed");
  bench.run(60);
  EXPECT_EQ(bench.pipeline.current().index, 2);
}

TEST(Pipeline, ForgetsWhatIsOlderThanItsMemory) {
  const Chain chain = free_chain();
  Rig rig = rig_of(chain, 3);
  rig.memory_s = 20;
  Bench bench(chain, rig, steady_drive(3), DrivenChain::Start::steady, {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  bench.run(100);
  const Dwell dwell = bench.pipeline.current();
  // To the length of the oldest block: with twelve of each length that is at most a twelfth.
  EXPECT_NEAR(dwell.phasors[0].samples, 20 * 100, 200);
  EXPECT_NEAR(dwell.settled_s, 80, 2);
  expect_within(dwell, chain, 4, "forgetting");
  EXPECT_NE(dwell.settling_reason.find("only the newest 2"), std::string::npos) << dwell.settling_reason;
  EXPECT_NE(dwell.settling_reason.find("estimation memory = 20"), std::string::npos) << dwell.settling_reason;
  bench.finish();
  ASSERT_EQ(bench.dwells.size(), 1u);
  EXPECT_NE(bench.dwells[0].settling_reason.find("only the newest"), std::string::npos);
}

TEST(Pipeline, ADwellThatFitsIntoItsMemorySaysNothingOfIt) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 3), steady_drive(3), DrivenChain::Start::rest,
              {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  bench.run(100);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  EXPECT_EQ(bench.pipeline.current().settling_reason.find("count"), std::string::npos)
      << bench.pipeline.current().settling_reason;
}

}  // namespace
}  // namespace dwell
