// The master against simulated nodes, in virtual time: set up, measured, and everything that befalls a bus.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/drivers/canopen_fixture.hpp"

namespace dwell::canopen {
namespace {

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
