// The master against simulated nodes, in virtual time: set up, measured, and everything that befalls a bus.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "drivers/canopen/words.hpp"
#include "tests/drivers/canopen_bench.hpp"

namespace dwell::canopen {
namespace {

using rigsim::Transducer;
using test::CanopenBench;
using test::kRawOffset_ns;

// Channels 10, 11, 12: nodes 1 (encoder), 2 (input), 5 (load cell).
class Canopen : public ::testing::Test {
 protected:
  void start() {
    bench_.start();
    ASSERT_TRUE(bench_.run_until([&] { return all_deliver(); }))
        << reason(10) << "; " << reason(11) << "; " << reason(12);
  }
  // Until the nodes have filled their dictionaries, and nobody has asked yet.
  void boot() { bench_.run_for(rigsim::CanopenNode::kBoot_ns + kMs_ns / 10); }
  bool all_deliver() const { return bench_.delivers(10) && bench_.delivers(11) && bench_.delivers(12); }
  std::string reason(std::uint16_t channel) const { return bench_.host.state_of(channel).reason; }
  dwell_fault fault(std::uint16_t channel) const { return bench_.host.state_of(channel).fault; }
  // Channel 13: another object of node 2, alone in its TPDO 2. Until node 2 boots again.
  void start_with_two_tpdos() {
    const Object object{0x7130, 1};
    bench_.setup.channels.push_back({13, "channel", 1});
    bench_.setup.nodes[1].wanted.push_back({object, *profile_type(object.index), 3});
    bench_.start();
    boot();
    bench_.node(2).set_entry(0x7130, 1, 7, 2, false);
    bench_.node(2).set_entry(0x1A01, 0, 1, 1, false);
    bench_.node(2).set_entry(0x1A01, 1, 0x71300110, 4, false);
    ASSERT_TRUE(bench_.run_until([&] { return all_deliver() && bench_.delivers(13); })) << reason(13);
  }
  // How often node 2 was told to reset its communication.
  std::ptrdiff_t resets() const {
    return std::count_if(bench_.sent.begin(), bench_.sent.end(), [](const can_frame& frame) {
      return frame.can_id == kNmt && frame.data[0] == 0x82 && frame.data[1] == 2;
    });
  }
  bool logged(const std::string& text) const {
    for (const std::string& line : bench_.host.logged())
      if (line.find(text) != std::string::npos) return true;
    return false;
  }
  // Every sample is what its node had at the instant it carries, which is a SYNC's.
  void expect_samples_of_their_sync(std::size_t from = 0) {
    const std::set<std::int64_t> syncs(bench_.syncs.begin(), bench_.syncs.end());
    const auto samples = bench_.host.samples();
    for (std::size_t i = from; i < samples.size(); ++i) {
      const dwell_sample& sample = samples[i];
      ASSERT_EQ(syncs.count(sample.t_ns), 1U);
      const std::uint8_t node = sample.channel == 10 ? 1 : sample.channel == 11 ? 2 : 5;
      const double si = bench_.quantity(node, sample.t_ns);
      ASSERT_NEAR(sample.raw, node == 5 ? si : si / 1e-9, node == 5 ? 1e-6 : 0.6) << sample.channel << " at " << i;
    }
  }
  void move() {
    bench_.quantity = [](std::uint8_t node, std::int64_t raw_ns) {
      return 1e-3 * node *
             std::sin(2e-9 * M_PI * 4.0 * static_cast<double>(raw_ns - kRawOffset_ns - 1'000 * kSecond_ns));
    };
  }

  CanopenBench bench_{{{1, Transducer::encoder}, {2, Transducer::input}, {5, Transducer::load_cell}}};
};

TEST_F(Canopen, SetsNodesUpAndSamplesThemAtTheInstantOfTheSync) {
  move();
  start();
  const std::size_t before = bench_.host.sample_count();
  bench_.run_for(kSecond_ns);
  EXPECT_NEAR(static_cast<double>(bench_.host.sample_count() - before), 300.0, 6.0);
  expect_samples_of_their_sync();
  for (const std::size_t scan : bench_.host.scans()) EXPECT_LE(scan, 3U);
  EXPECT_EQ(bench_.host.scans().back(), 3U);
  EXPECT_EQ(bench_.host.counted(DWELL_FAULT_TIMEOUT) + bench_.host.counted(DWELL_FAULT_LATE_ANSWER) +
                bench_.host.counted(DWELL_FAULT_EXCEPTION),
            0);
  EXPECT_EQ(bench_.host.samples().back().flags, 0U);
  for (const std::uint8_t id : {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{5}}) {
    EXPECT_EQ(bench_.node(id).entry(0x1800, 2), 1U) << +id;
    EXPECT_EQ(bench_.node(id).entry(0x1800, 1), 0x180U + id);
    EXPECT_EQ(bench_.node(id).entry(0x1017, 0), 100U);
  }
  EXPECT_TRUE(logged("node 2 (CiA 404, rigsim input): started; measured by TPDO 1 (0x182)"));
}

TEST_F(Canopen, WritesNothingIntoATpdoThatIsAsItMustBe) {
  start();
  for (const can_frame& frame : bench_.sent) {
    const bool writes = frame.can_id == kSdoRequest + 5 && frame.data[0] >> 5U == 1U;
    EXPECT_FALSE(writes && frame.data[2] == 0x18 && frame.data[1] < 0x10);
  }
}

TEST_F(Canopen, KnowsTheSyncByTheInstantOfSendingWhereItDoesNotComeBack) {
  bench_.sync_returns = false;
  move();
  start();
  bench_.run_for(kSecond_ns);
  expect_samples_of_their_sync();
  EXPECT_EQ(bench_.host.samples().back().t_half_ns, 5'001U);
}

TEST_F(Canopen, KeepsThePeriodOfTheMonotonicClock) {
  start();
  const std::size_t first = bench_.syncs.size() - 1;
  bench_.run_for(10 * kSecond_ns);
  const std::int64_t span_ns = bench_.syncs.back() - bench_.syncs[first];
  EXPECT_NEAR(static_cast<double>(span_ns) / static_cast<double>(bench_.syncs.size() - 1 - first), 1e7, 100.0);
}

TEST_F(Canopen, GivesATpdoAnIdentifierOfTheNodesOwnWhereItHasNone) {
  bench_.start();
  boot();
  bench_.node(1).set_entry(0x1800, 1, 0x80000000, 4, true);
  bench_.node(5).set_entry(0x1800, 1, 0x666, 4, true);  // not its own
  bench_.node(5).set_entry(0x1801, 1, 0x185, 4, true);  // its own, and taken
  ASSERT_TRUE(bench_.run_until([&] { return all_deliver(); })) << reason(10) << "; " << reason(12);
  EXPECT_EQ(bench_.node(1).entry(0x1800, 1), 0x181U);
  EXPECT_EQ(bench_.node(5).entry(0x1800, 1), 0x285U);
}

TEST_F(Canopen, MarksAWrongMappingWithNodeObjectAndWhatWasFound) {
  bench_.node(1).map_wrongly(true);
  bench_.start();
  ASSERT_TRUE(bench_.run_until([&] { return fault(10) == DWELL_FAULT_EXCEPTION && bench_.delivers(12); }));
  EXPECT_EQ(reason(10),
            "node 1 (CiA 406, rigsim encoder): object 6004h:00 is not mapped into any TPDO; mapped are 6030h:01 (16 "
            "bits, TPDO 1)");
  // Mended, it comes by itself.
  bench_.node(1).map_wrongly(false);
  bench_.node(1).reset(bench_.now_ns());
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

TEST_F(Canopen, MarksAWidthThatIsAnother) {
  bench_.setup.nodes[1].wanted[0].type = {Kind::signed_integer, 16};
  bench_.start();
  ASSERT_TRUE(bench_.run_until([&] { return fault(11) == DWELL_FAULT_EXCEPTION; }));
  EXPECT_EQ(reason(11),
            "node 2 (CiA 404, rigsim input): object 9130h:01 is mapped into TPDO 1 with 32 bits, but integer16 has 16");
}

TEST_F(Canopen, RefusesAnotherDeviceThanTheRigFileNames) {
  bench_.setup.nodes[0].identity = {rigsim::CanopenNode::kVendor, 0x6004, std::nullopt, 1001};
  bench_.setup.nodes[1].identity = {std::nullopt, std::nullopt, std::nullopt, 7};
  bench_.start();
  ASSERT_TRUE(bench_.run_until([&] { return bench_.delivers(10) && fault(11) == DWELL_FAULT_EXCEPTION; }));
  EXPECT_EQ(
      reason(11),
      "node 2 (CiA 404, rigsim input): is another device: its serial_number (1018h:04) is 0x3EA, the rig file says "
      "0x7");
}

TEST_F(Canopen, SetsANodeUpAgainThatRestarts) {
  start();
  bench_.run_for(kSecond_ns);
  bench_.node(2).reset(bench_.now_ns());
  ASSERT_TRUE(bench_.run_until([&] { return fault(11) == DWELL_FAULT_DISCONNECTED; }));
  EXPECT_NE(reason(11).find("it has restarted"), std::string::npos);
  ASSERT_TRUE(bench_.run_until([&] { return all_deliver(); }));
  const std::size_t from = bench_.host.sample_count();
  bench_.run_for(kSecond_ns);
  expect_samples_of_their_sync(from);
  EXPECT_EQ(fault(10), DWELL_FAULT_NONE);
}

TEST_F(Canopen, SetsANodeUpAgainThatLeavesOperation) {
  start();
  bench_.run_for(kSecond_ns);
  bench_.node(1).take(nmt_frame(Command::pre_operational, 1), bench_.now_ns());  // by somebody else
  ASSERT_TRUE(bench_.run_until([&] { return fault(10) == DWELL_FAULT_DISCONNECTED; }));
  EXPECT_EQ(reason(10), "node 1 (CiA 406, rigsim encoder): it was started, and is pre-operational");
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

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

TEST_F(Canopen, TellsEmergenciesInWords) {
  start();
  bench_.node(5).emergency(0x4210, 0x09);
  bench_.run_for(10 * kMs_ns);
  EXPECT_TRUE(
      logged("node 5 (CiA 404, rigsim load cell): emergency 0x4210 (device temperature), error register 0x09 "
             "(generic, temperature)"));
  EXPECT_EQ(bench_.host.counted(DWELL_FAULT_EXCEPTION), 1);
  for (int i = 0; i < 1000; ++i) bench_.node(5).emergency(0x2310, 0x03);
  bench_.run_for(2 * kSecond_ns);
  bench_.node(5).emergency(0, 0);
  bench_.run_for(10 * kMs_ns);
  EXPECT_EQ(bench_.host.counted(DWELL_FAULT_EXCEPTION), 1001);
  EXPECT_TRUE(logged("(error reset or no error)"));
  EXPECT_TRUE(logged("1000 others since the last line"));
  EXPECT_LT(bench_.host.logged().size(), 10U);
  EXPECT_TRUE(bench_.delivers(12));
}

TEST_F(Canopen, TellsAnAbortThatItCannotDoWithout) {
  bench_.start();
  boot();
  bench_.node(1).set_entry(0x1800, 2, 254, 1, false);
  ASSERT_TRUE(bench_.run_until([&] { return fault(10) == DWELL_FAULT_EXCEPTION; }));
  EXPECT_EQ(
      reason(10),
      "node 1 (CiA 406, rigsim encoder): TPDO 1 cannot be sent at every SYNC, 1800h:02: attempt to write a read only "
      "object (0x06010002)");
}

TEST_F(Canopen, DoesWithoutAHeartbeatOfTheNode) {
  bench_.start();
  boot();
  bench_.node(1).remove_entry(0x1017, 0);
  ASSERT_TRUE(bench_.run_until([&] { return all_deliver(); }));
  bench_.run_for(3 * kSecond_ns);
  EXPECT_TRUE(all_deliver());
  EXPECT_TRUE(logged("it sends no heartbeat"));
}

TEST_F(Canopen, ComesUpThoughAnswersAreLost) {
  std::uint32_t random = 7;
  bench_.fate = [&](const can_frame&) -> std::optional<std::int64_t> {
    random = random * 1664525U + 1013904223U;
    if ((random >> 24U) < 8) return std::nullopt;
    return 0;
  };
  bench_.start();
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

TEST_F(Canopen, SaysWhenSyncCannotBeSent) {
  start();
  bench_.sync_blocked = true;
  ASSERT_TRUE(bench_.run_until([&] { return fault(12) == DWELL_FAULT_TIMEOUT; }));
  EXPECT_EQ(reason(12), "can0: SYNC cannot be sent: No buffer space available");
  EXPECT_GT(bench_.host.counted(DWELL_FAULT_MISSED_DEADLINE), 50);
  bench_.sync_blocked = false;
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

TEST_F(Canopen, WarnsOnceOfAnotherSync) {
  start();
  for (int i = 0; i < 3; ++i) bench_.inject(make_frame(kSync, {}));
  bench_.run_for(10 * kMs_ns);
  EXPECT_TRUE(logged("somebody else sends SYNC as well"));
  EXPECT_EQ(bench_.host.counted(DWELL_FAULT_BAD_FRAME), 3);
}

TEST_F(Canopen, MarksWhatIsNoNumber) {
  start();
  bench_.quantity = [](std::uint8_t node, std::int64_t) { return node == 5 ? std::nan("") : 0.0; };
  ASSERT_TRUE(bench_.run_until([&] { return fault(12) == DWELL_FAULT_INVALID_VALUE; }));
  bench_.quantity = [](std::uint8_t, std::int64_t) { return 1.0; };
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

TEST_F(Canopen, EndsWithTheBusAndBeginsWithIt) {
  start();
  bench_.network().hold(DWELL_FAULT_DISCONNECTED, "can0: the link is down");
  EXPECT_EQ(fault(11), DWELL_FAULT_DISCONNECTED);
  bench_.run_for(kSecond_ns);
  EXPECT_EQ(fault(11), DWELL_FAULT_DISCONNECTED);
  bench_.network().begin(bench_.now_ns());
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

TEST_F(Canopen, SaysOnceASecondThatANodeRestartsAgainAndAgain) {
  start();
  for (int i = 0; i < 1000; ++i) {
    bench_.inject(make_frame(kHeartbeat + 2, {0}));
    bench_.run_for(kMs_ns);
  }
  EXPECT_LT(bench_.host.logged().size(), 12U);
  EXPECT_GT(bench_.host.counted(DWELL_FAULT_DISCONNECTED), 500);
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
}

// Random frames of every identifier: nothing but counts, and afterwards all is as before.
TEST_F(Canopen, SurvivesAHostileStream) {
  start();
  std::uint32_t random = 3;
  const auto next = [&] { return random = random * 1664525U + 1013904223U; };
  for (int i = 0; i < 20'000; ++i) {
    can_frame frame{};
    frame.can_id = next() >> 21U;
    frame.can_dlc = static_cast<std::uint8_t>(next() >> 28U);
    if (frame.can_dlc > 8) frame.can_dlc = 8;
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(next() >> 24U);
    bench_.inject(frame);
    if (i % 10 == 0) bench_.run_for(kMs_ns);
  }
  EXPECT_TRUE(bench_.run_until([&] { return all_deliver(); }));
  for (const dwell_sample& sample : bench_.host.samples()) EXPECT_TRUE(std::isfinite(sample.raw));
}

}  // namespace
}  // namespace dwell::canopen
