// Nodes that are silent, and answers that are lost or late: stale with the reason, and never a wrong instant.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/drivers/canopen_fixture.hpp"

namespace dwell::canopen {
namespace {

TEST_F(Canopen, IsStaleWhileANodeIsSilentAndSaysWhich) {
  start();
  bench_.run_for(kSecond_ns);
  bench_.fate = [](const can_frame& frame) -> std::optional<std::int64_t> {
    if ((frame.can_id & kNodeMask) == 2) return std::nullopt;
    return 0;
  };
  ASSERT_TRUE(bench_.run_until([&] { return fault(11) == DWELL_FAULT_TIMEOUT; }));
  EXPECT_EQ(reason(11), "node 2 (CiA 404, rigsim input): no heartbeat for 0.3 s");
  bench_.run_for(8 * kSecond_ns);
  EXPECT_EQ(fault(11), DWELL_FAULT_TIMEOUT);
  EXPECT_NE(reason(11).find("node 2: no answer when asked for 1000h:00"), std::string::npos) << reason(11);
  // The others are measured all the while, without a pause.
  EXPECT_TRUE(bench_.delivers(10) && bench_.delivers(12));
  const auto samples = bench_.host.samples(10);
  EXPECT_EQ(samples.back().t_ns - samples[samples.size() - 101].t_ns, kSecond_ns);
  bench_.fate = [](const can_frame&) { return 0; };
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

TEST_F(Canopen, IsStaleWhenANodeLivesButDoesNotAnswerSync) {
  bench_.fate = [](const can_frame& frame) -> std::optional<std::int64_t> {
    if (frame.can_id == 0x185) return std::nullopt;
    return 0;
  };
  bench_.start();
  ASSERT_TRUE(bench_.run_until([&] { return fault(12) == DWELL_FAULT_TIMEOUT; }));
  EXPECT_EQ(reason(12), "node 5 (CiA 404, rigsim load cell): no answer to SYNC for 1 s");
}

TEST_F(Canopen, IsStaleInOneTpdoAloneWhileAnotherOfItsNodeAnswers) {
  bench_.setup.timeout_ns = kSecond_ns / 2;
  start_with_two_tpdos();
  bench_.fate = [](const can_frame& frame) -> std::optional<std::int64_t> {
    if (frame.can_id == 0x282) return std::nullopt;
    return 0;
  };
  ASSERT_TRUE(bench_.run_until([&] { return fault(13) == DWELL_FAULT_TIMEOUT; }));
  EXPECT_EQ(reason(13), "node 2 (CiA 404, rigsim input): TPDO 2 (0x282): no answer to SYNC for 0.5 s");
  const std::size_t told = bench_.host.states_told(), samples = bench_.host.samples(11).size();
  bench_.run_for(10 * kSecond_ns);
  EXPECT_EQ(resets(), 1);
  EXPECT_EQ(bench_.host.states_told(), told);
  EXPECT_NEAR(static_cast<double>(bench_.host.samples(11).size() - samples), 1000.0, 2.0);
  bench_.fate = [](const can_frame&) { return 0; };
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver() && bench_.delivers(13); }));
  EXPECT_EQ(resets(), 1);
}

TEST_F(Canopen, SetsANodeUpAgainOnceAllOfItsTpdosAreSilent) {
  bench_.setup.timeout_ns = kSecond_ns / 2;
  start_with_two_tpdos();
  bool both = false;
  bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    if (frame.can_id == 0x282 || (both && frame.can_id == 0x182)) return std::nullopt;
    return 0;
  };
  ASSERT_TRUE(bench_.run_until([&] { return fault(13) == DWELL_FAULT_TIMEOUT; }));
  both = true;
  ASSERT_TRUE(bench_.run_until([&] { return fault(11) == DWELL_FAULT_TIMEOUT; }));
  for (const std::uint16_t channel : {std::uint16_t{11}, std::uint16_t{13}})
    EXPECT_EQ(reason(channel), "node 2 (CiA 404, rigsim input): no answer to SYNC for 0.5 s");
  EXPECT_TRUE(bench_.run_until([&] { return resets() == 2; }));
}

// The one that answers must not undo the back-off that the silent one has earned.
TEST(CanopenNode, IsTriedAtOnceAgainOnlyAfterAllOfItsTpdosHaveAnswered) {
  test::FakeHost host;
  Outbox outbox;
  Wish wish;
  wish.node = 2;
  const auto pause_ns = [&](Node& node) {
    outbox.clear();
    node.fail(DWELL_FAULT_TIMEOUT, "silent", 0);
    std::int64_t now_ns = 0;
    for (; outbox.front() == nullptr && now_ns < 20 * kSecond_ns; now_ns += kMs_ns) node.tick(now_ns);
    return now_ns - kMs_ns;
  };
  Node node(wish, driver::Host(*host.host()), outbox);
  EXPECT_EQ(pause_ns(node), 100 * kMs_ns);
  node.answers(false);
  EXPECT_EQ(node.fault(), DWELL_FAULT_NONE);
  EXPECT_EQ(pause_ns(node), 200 * kMs_ns);
  node.answers(true);
  EXPECT_EQ(pause_ns(node), 100 * kMs_ns);
}

TEST_F(Canopen, LosesNothingButTheAnswerThatIsLostAndTheDoubtfulOneAfterIt) {
  move();
  start();
  bench_.run_for(kSecond_ns);
  const std::size_t from = bench_.host.sample_count(), lost = bench_.host.samples(11).size();
  int pdos = 0;
  bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    if (frame.can_id == 0x182 && ++pdos == 10) return std::nullopt;
    return 0;
  };
  const std::size_t syncs = bench_.syncs.size();
  bench_.run_for(2 * kSecond_ns);
  expect_samples_of_their_sync(from);
  EXPECT_EQ(bench_.host.counted(DWELL_FAULT_TIMEOUT), 1);
  EXPECT_EQ(bench_.host.counted(DWELL_FAULT_LATE_ANSWER), 1);
  EXPECT_EQ(bench_.host.samples(11).size() - lost, bench_.syncs.size() - syncs - 2);
  EXPECT_NEAR(static_cast<double>(bench_.syncs.size() - syncs), 196.0, 1.0);  // a pause of 50 ms
  int gaps = 0;
  for (const dwell_sample& sample : bench_.host.samples(11)) gaps += (sample.flags & DWELL_SAMPLE_GAP) != 0 ? 1 : 0;
  EXPECT_EQ(gaps, 1);
}

// Late by less than a period, by one, by some: whatever comes after the next SYNC is counted, and nothing else is lost.
TEST_F(Canopen, NeverGivesALateAnswerToAnotherSync) {
  move();
  start();
  std::uint32_t random = 1;
  bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    random = random * 1664525U + 1013904223U;
    if (frame.can_id < kFirstPdo || frame.can_id > kLastPdo) return 0;
    if ((random >> 24U) < 8) return std::nullopt;
    return (random >> 24U) < 24 ? (random >> 8U) % 40 * kMs_ns : 0;
  };
  bench_.run_for(60 * kSecond_ns);
  expect_samples_of_their_sync();
  EXPECT_GT(bench_.host.counted(DWELL_FAULT_LATE_ANSWER), 100);
  EXPECT_GT(bench_.host.sample_count(), 4000U);
}

// A rig that loses and delays much is measured all the same, at a lower rate, and no node is set up again for it.
TEST_F(Canopen, MeasuresThoughManyAnswersAreLostAndLate) {
  bench_.setup.timeout_ns = kSecond_ns / 2;
  move();
  start();
  std::uint32_t random = 5;
  bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    random = random * 1664525U + 1013904223U;
    if (frame.can_id < kFirstPdo || frame.can_id > kLastPdo) return 0;
    if ((random >> 24U) < 8) return std::nullopt;
    return (random >> 24U) < 16 ? 30 * kMs_ns : 0;
  };
  const std::size_t before = bench_.host.sample_count(), states = bench_.host.states_told();
  bench_.run_for(60 * kSecond_ns);
  expect_samples_of_their_sync(before);
  EXPECT_GT(bench_.host.sample_count() - before, 7200U);  // two of five
  EXPECT_EQ(bench_.host.states_told(), states);
}

// After node 1 has lost its answer, and all have paused for it, node 2 loses the one to each of the next SYNCs in turn.
TEST_F(Canopen, IsNotStaleForOneAnswerThatIsLostWhileNoPauseIsDue) {
  bench_.setup.late_ns = 41 * kMs_ns;
  bench_.setup.timeout_ns = longest_gap_ns(bench_.setup) + 1;
  start();
  const std::size_t from = bench_.host.samples(11).size(), told = bench_.host.states_told();
  for (int lost = 1; lost < 20; ++lost) {
    int first = 0, second = 0;
    bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
      if ((frame.can_id == 0x181 && ++first == 3) || (frame.can_id == 0x182 && ++second == lost)) return std::nullopt;
      return 0;
    };
    bench_.run_for(kSecond_ns);
    ASSERT_EQ(bench_.host.states_told(), told) << lost << ": " << reason(11);
  }
  std::int64_t longest_ns = 0;
  const auto samples = bench_.host.samples(11);
  for (std::size_t i = from; i < samples.size(); ++i)
    longest_ns = std::max(longest_ns, samples[i].t_ns - samples[i - 1].t_ns);
  EXPECT_GE(longest_ns, bench_.setup.timeout_ns - 2 * bench_.setup.period_ns) << "so long it does take";
}

TEST_F(Canopen, SaysThatAnswersComeTooLateForTheRate) {
  start();
  bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    return frame.can_id == 0x182 ? 15 * kMs_ns : 0;
  };
  ASSERT_TRUE(bench_.run_until([&] { return fault(11) == DWELL_FAULT_LATE_ANSWER; }));
  EXPECT_NE(reason(11).find("its answers are lost, or come later than the next SYNC; expected a lower `rate`"),
            std::string::npos)
      << reason(11);
  EXPECT_TRUE(bench_.delivers(10));
  // The others lose a pause of 50 ms per timeout of 1 s to it, that is four SYNCs of a hundred.
  const std::size_t before = bench_.host.samples(10).size();
  bench_.run_for(10 * kSecond_ns);
  EXPECT_EQ(fault(11), DWELL_FAULT_LATE_ANSWER);
  EXPECT_GE(bench_.host.samples(10).size() - before, 1000U - 10U * 4U);
}

TEST_F(Canopen, NoticesWithinATimeoutThatATpdoHasBecomeFastEnough) {
  start();
  bool slow = true;
  int lost = 0;
  bench_.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    if (frame.can_id != 0x182) return 0;
    if (slow) return 15 * kMs_ns;
    if (++lost == 1) return std::nullopt;  // else as many answers would have come as SYNCs gone out
    return 0;
  };
  ASSERT_TRUE(bench_.run_until([&] { return fault(11) == DWELL_FAULT_LATE_ANSWER; }));
  bench_.run_for(kSecond_ns / 4);
  slow = false;
  const std::int64_t from_ns = bench_.now_ns();
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); })) << reason(11);
  const std::int64_t trial_ns = bench_.setup.timeout_ns + bench_.setup.late_ns + 3 * bench_.setup.period_ns;
  EXPECT_LE(bench_.now_ns() - from_ns, trial_ns);
  EXPECT_GE(bench_.now_ns() - from_ns, bench_.setup.timeout_ns / 4) << "a pause it was that showed it";
}

}  // namespace
}  // namespace dwell::canopen
