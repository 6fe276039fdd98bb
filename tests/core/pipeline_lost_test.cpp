// Channels that are lost, and what the pipeline says of the drive that it no longer sees.
#include <gtest/gtest.h>

#include "core/dwell/pipeline.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

TEST(Pipeline, ADriveThatIsNoLongerSeenEndsTheDwellAsDataLost) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 3), steady_drive(3), DrivenChain::Start::steady,
              {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  bench.run(10);
  bench.alter = [&](Record& record, double t) {
    if (record.channel == 0 && t < 14) record.kind = Kind::tick;
  };
  bench.run(14);
  ASSERT_EQ(bench.dwells.size(), 1u);
  EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::data_lost);
  expect_within(bench.dwells[0], chain, 4, "until the loss");
  EXPECT_EQ(bench.pipeline.state(), State::fault);
  bench.run(30);
  EXPECT_EQ(bench.pipeline.state(), State::measuring);
  expect_within(bench.pipeline.current(), chain, 4, "after the return");
}

// At 1 Hz the newest two periods still hold some readings when the channel counts as lost.
TEST(Pipeline, ALostChannelIsTheReasonAndNotItsFewReadings) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 1), steady_drive(1), DrivenChain::Start::steady,
              {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  const double lost_s = 20.3, back_s = 40.0, lost_again_s = 40.4;
  bench.alter = [&](Record& record, double t) {
    if (record.channel == 0 && ((t > lost_s && t < back_s) || t > lost_again_s)) record.kind = Kind::tick;
  };
  const auto reason = [&] { return bench.pipeline.current().settling_reason; };
  bench.run(lost_s);
  ASSERT_EQ(bench.pipeline.state(), State::measuring);
  while (bench.now_s() < 60) {
    bench.run(bench.now_s() + 0.1);
    EXPECT_EQ(reason().find("too few samples"), std::string::npos) << bench.now_s() << " s: " << reason();
    if (bench.pipeline.state() != State::fault) continue;
    const double since_last_s = bench.now_s() - lost_again_s;
    if (since_last_s > 1.9 && since_last_s < 2.1) continue;  // counts as lost from two periods on: about now
    const bool delivers = bench.now_s() > back_s && since_last_s < 2.0;
    EXPECT_EQ(reason(), delivers ? "the drive is not seen yet: y0 delivers again, its first periods are awaited"
                                 : "the drive is not seen: y0 is silent")
        << bench.now_s() << " s";
  }
  EXPECT_EQ(bench.pipeline.state(), State::fault);
}

TEST(Pipeline, AChannelThatComesBackWithTooFewReadingsSaysSo) {
  const Chain chain = free_chain();
  Bench bench(chain, rig_of(chain, 1), steady_drive(1), DrivenChain::Start::steady,
              {.rate_hz = 100, .sigma = {1e-6, 1e-6, 1e-6}});
  int n = 0;
  bench.alter = [&](Record& record, double t) {
    if (record.channel == 0 && (t < 40 ? t > 20 : n++ % 40 != 0)) record.kind = Kind::tick;
  };
  bench.run(60);
  EXPECT_EQ(bench.pipeline.state(), State::fault);
  EXPECT_NE(bench.pipeline.current().settling_reason.find("y0 has too few samples a period"), std::string::npos)
      << bench.pipeline.current().settling_reason;
}

}  // namespace
}  // namespace dwell
