#include "daemon/acquire/device_link.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace dwell {
namespace {

// Channels 3 and 7 of a rig, a ring for ten samples.
struct Fixture : testing::Test {
  DeviceLink link{"amplifier", {3, 7}, 10, nullptr};
  std::int64_t t_ns = 0;

  bool scan() {
    t_ns += 1000;
    const std::array<dwell_sample, 2> samples{dwell_sample{t_ns, 1.0, 5, 3, 0}, dwell_sample{t_ns, 2.0, 5, 7, 0}};
    return link.push(samples.data(), samples.size());
  }
  std::vector<Record> drain() {
    std::vector<Record> records(100);
    records.resize(link.pop_samples(records.data(), records.size()));
    return records;
  }
};
using DeviceLinkTest = Fixture;

TEST_F(DeviceLinkTest, CarriesASampleUnchanged) {
  const dwell_sample sample{123, 4.5, 67, 7, DWELL_SAMPLE_STAMP_REPLACED};
  ASSERT_TRUE(link.push(&sample, 1));
  const auto records = drain();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].t_ns, 123);
  EXPECT_EQ(records[0].value, 4.5);
  EXPECT_EQ(records[0].t_half_ns, 67u);
  EXPECT_EQ(records[0].channel, 7);
  EXPECT_EQ(records[0].kind, Kind::sample);
  EXPECT_EQ(records[0].flags, kStampReplaced);
}

TEST_F(DeviceLinkTest, AScanThatDoesNotFitWholeIsRefusedWhole) {
  while (scan()) {
  }
  const dwell_sample one{t_ns, 1.0, 5, 3, 0};
  (void)link.push(&one, 1);  // an odd capacity would have room for one more
  const auto records = drain();
  EXPECT_GE(records.size(), 10u);
  EXPECT_EQ(records.size() % 2, 0u) << "no half scan";
}

TEST_F(DeviceLinkTest, TellsTheRoomThatTheNextPushFinds) {
  const dwell_host host = link.host();
  ASSERT_NE(host.room, nullptr);
  for (std::size_t room = host.room(host.context); room >= 2; room -= 2) {
    EXPECT_EQ(host.room(host.context), room);
    ASSERT_TRUE(scan());
  }
  EXPECT_FALSE(scan());
}

TEST_F(DeviceLinkTest, EverySampleIsAccountedFor) {
  int refused = 0;
  for (int i = 0; i < 40; ++i) refused += scan() ? 0 : 1;
  ASSERT_GT(refused, 0);
  const Tally tally = link.counters(0).read();
  EXPECT_EQ(tally.received, 40u);
  EXPECT_EQ(tally.refused, static_cast<std::uint64_t>(refused));
  EXPECT_EQ(tally.received, tally.used + tally.dropped() + tally.queued);
  EXPECT_EQ(2 * tally.queued, drain().size()) << "queued is what really waits";
}

TEST_F(DeviceLinkTest, TheGapRidesOnTheNextAcceptedSampleOfThatChannelAlone) {
  while (scan()) {
  }
  (void)drain();
  const dwell_sample other{t_ns, 1.0, 5, 3, 0};
  ASSERT_TRUE(link.push(&other, 1));
  ASSERT_TRUE(scan());
  ASSERT_TRUE(scan());
  const auto records = drain();
  ASSERT_EQ(records.size(), 5u);
  EXPECT_EQ(records[0].flags, kGap);
  EXPECT_EQ(records[1].flags, 0) << "channel 3 has told its gap";
  EXPECT_EQ(records[2].flags, kGap) << "channel 7 tells its own";
  EXPECT_EQ(records[3].flags, 0);
  EXPECT_EQ(records[4].flags, 0);
}

TEST_F(DeviceLinkTest, AForeignChannelIsRefusedAndCounted) {
  for (const std::uint16_t channel : std::array<std::uint16_t, 4>{0, 5, 8, 65535}) {
    const dwell_sample sample{1, 1.0, 5, channel, 0};
    EXPECT_FALSE(link.push(&sample, 1));
    link.state(channel, DWELL_FAULT_TIMEOUT, nullptr);
  }
  EXPECT_EQ(link.foreign(), 8u);
  StateEvent event;
  EXPECT_FALSE(link.pop_event(event));
  EXPECT_TRUE(drain().empty());
}

TEST_F(DeviceLinkTest, AStateSaidTooOftenEndsInTheLastOne) {
  for (int i = 0; i < 1000; ++i) link.state(-1, i % 2 == 0 ? DWELL_FAULT_TIMEOUT : DWELL_FAULT_NONE, "flapping");
  link.state(3, DWELL_FAULT_DISCONNECTED, "the last word");
  std::array<Fault, 8> last{};
  StateEvent event;
  for (int turn = 0; turn < 2; ++turn) {
    while (link.pop_event(event)) {
      for (const int channel : {3, 7})
        if (event.channel < 0 || event.channel == channel) last[static_cast<std::size_t>(channel)] = event.fault;
    }
    link.turn(t_ns);
  }
  EXPECT_EQ(last[3], Fault::disconnected);
  EXPECT_EQ(last[7], Fault::none);
}

TEST_F(DeviceLinkTest, ReasonsAreCutAndCannotForgeLines) {
  const std::string reason = "bad\nthing\x1b[31m\u202E" + std::string(1000, 'x');
  link.state(-1, DWELL_FAULT_BAD_FRAME, reason.c_str());
  StateEvent event;
  ASSERT_TRUE(link.pop_event(event));
  const std::string seen = event.reason.data();
  EXPECT_LT(seen.size(), StateEvent::kReasonSize);
  EXPECT_EQ(seen.substr(0, 17), "bad thing [31m xx");
}

TEST_F(DeviceLinkTest, CountsFaultsByKindUnknownOnesIncluded) {
  const dwell_host host = link.host();
  host.count(host.context, DWELL_FAULT_TIMEOUT, 1);
  host.count(host.context, DWELL_FAULT_TIMEOUT, 3'000'000'000);
  host.count(host.context, static_cast<dwell_fault>(kFaultCount), 1);
  EXPECT_EQ(link.faults(Fault::timeout), 3'000'000'001u);
  EXPECT_EQ(link.faults(Fault::bad_frame), 1u);
}

TEST_F(DeviceLinkTest, ALogThatThrowsDoesNotReachTheDriver) {
  DeviceLink throwing("d", {0}, 4, [](dwell_level, const char*) { throw std::runtime_error("disk full"); });
  const dwell_host host = throwing.host();
  EXPECT_NO_THROW(host.log(host.context, DWELL_ERROR, "x"));
}

}  // namespace
}  // namespace dwell
