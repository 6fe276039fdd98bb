// One device on its way into the stream.
#include "daemon/estimate/device_intake.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/daemon/log_to_read.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

struct DeviceIntakeTest : testing::Test {
  DeviceIntakeTest() {
    rig.devices = {{"a"}};
    for (const char* name : {"y0", "y1"}) {
      Channel& channel = rig.channels.emplace_back();
      channel.name = name;
      channel.device = 0;
    }
    assembler.emplace(Assembler::sources(rig), 100 * kMs_ns, 10'000);
    intake.emplace(0, DeviceFeed{&link, "modbus", 200.0}, rig, *assembler, 100 * kMs_ns, log, now_ns);
    assembler->set_now(now_ns);
    link.turn(now_ns);
  }
  void push(std::int64_t t_ns) {
    const dwell_sample scan[2] = {{t_ns, 1.0, 1000, 0, 0}, {t_ns, 2.0, 1000, 1, 0}};
    ASSERT_TRUE(link.push(scan, 2));
  }
  // The kinds of all records that wait in the merger, by their first letters.
  std::string stream() {
    std::string kinds;
    for (Record record; assembler->flush(record);)
      kinds += record.kind == Kind::sample          ? 's'
               : record.kind != Kind::channel_state ? '?'
               : record.flags == 0                  ? 'u'
                                                    : 'd';
    return kinds;
  }
  DeviceView view() {
    const Pipeline pipeline(rig);
    shown.channels.resize(2);
    shown.devices.resize(1);
    intake->show(rig, pipeline, StreamAccounts(rig.channels.size()), now_ns, shown);
    return shown.devices[0];
  }

  Rig rig;
  test::LogToRead log{"intake"};
  DeviceLink link{"a", {0, 1}, 4096, nullptr};
  std::int64_t now_ns = 5 * kSecond_ns;
  Snapshot shown;
  std::optional<Assembler> assembler;
  std::optional<DeviceIntake> intake;
};

TEST_F(DeviceIntakeTest, HandsOnEverySampleAndThatTheChannelsAreUp) {
  push(now_ns + 1 * kMs_ns);
  push(now_ns + 6 * kMs_ns);
  now_ns += 10 * kMs_ns;
  intake->take(now_ns);
  EXPECT_EQ(stream(), "ususss") << "up, then its samples";
  EXPECT_EQ(view().name, "a");
  EXPECT_EQ(view().driver, "modbus");
  EXPECT_TRUE(view().up);
  EXPECT_EQ(log.lines(), std::vector<std::string>{"info device a: y0, y1 delivering"});
}

TEST_F(DeviceIntakeTest, ReadingsInTheWrongOrderOfWordsHintAtTypeAndOrder) {
  const auto hinted = [this](std::size_t channel) {
    (void)view();
    return shown.channels[channel].condition_reason.find("check type and order") != std::string::npos;
  };
  const auto read = [this](int from, int to, bool swapped) {
    for (int i = from; i < to; ++i) {
      const double motion = 4.7 * std::sin(0.05 * i);  // exactly 0 at first
      auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(motion));
      if (swapped) bits = bits << 16 | bits >> 16;
      // A gateway's zeros and a spike now and then are no such thing.
      const double other = i % 50 == 7 ? 1e30 : i % 10 == 3 ? 0.0 : motion;
      now_ns += 5 * kMs_ns;
      const dwell_sample scan[2] = {{now_ns, std::bit_cast<float>(bits), 1000, 0, 0}, {now_ns, other, 1000, 1, 0}};
      ASSERT_TRUE(link.push(scan, 2));
      intake->take(now_ns);
      (void)stream();
    }
  };
  read(0, 200, true);
  EXPECT_TRUE(hinted(0)) << shown.channels[0].condition_reason;
  EXPECT_FALSE(hinted(1)) << shown.channels[1].condition_reason;
  read(200, 600, false);
  EXPECT_FALSE(hinted(0)) << "the order was corrected";
}

TEST_F(DeviceIntakeTest, ADriverThatDoesNotTurnIsFoundAndToldOfOnce) {
  push(now_ns + 1 * kMs_ns);
  now_ns += 10 * kMs_ns;
  intake->take(now_ns);
  (void)stream();
  // Its samples go on coming from the ring: it is the thread that hangs.
  now_ns += DeviceIntake::kHung_ns;
  push(now_ns - 1 * kMs_ns);
  intake->take(now_ns);
  (void)stream();
  intake->find_faults(now_ns);
  intake->find_faults(now_ns + 10 * kMs_ns);
  EXPECT_EQ(stream(), "dd");
  EXPECT_EQ(view().faults[static_cast<std::size_t>(Fault::silent)], 1u);
  EXPECT_FALSE(view().up);
  EXPECT_FALSE(view().ended);
  EXPECT_EQ(shown.channels[1].reason, "its driver hangs: no turn of its thread for 3.0 s");
}

// Stopped by SIGSTOP, by a debugger, or with the computer suspended: the fault is found when the service goes on, and
// the next reading comes a moment later.
TEST_F(DeviceIntakeTest, TheTimeForWhichTheServiceItselfWasStoppedCountsAsNotDelivered) {
  const auto turn = [this] {
    link.turn(now_ns);
    push(now_ns + 1 * kMs_ns);
    now_ns += 10 * kMs_ns;
    intake->take(now_ns);
    intake->find_faults(now_ns);
    (void)stream();
  };
  turn();
  now_ns += 100 * kSecond_ns;  // so that the log has room for the line
  link.turn(now_ns);
  turn();
  push(now_ns);  // waits in the ring while the service is stopped
  now_ns += 20 * kSecond_ns;
  intake->take(now_ns);
  intake->find_faults(now_ns);
  (void)stream();
  turn();
  const std::string last = log.lines().back();
  EXPECT_NE(last.find("y0, y1 delivering again after 20.0 s"), std::string::npos) << last;
}

TEST_F(DeviceIntakeTest, ARecordingPlayedToItsEndHasNothingLeftToTurnFor) {
  link.state(-1, DWELL_FAULT_END_OF_DATA, nullptr);
  intake->take(now_ns);
  now_ns += 100 * kSecond_ns;
  intake->find_faults(now_ns);
  EXPECT_TRUE(view().ended);
  EXPECT_EQ(shown.channels[0].fault, Fault::end_of_data);
  EXPECT_EQ(view().faults[static_cast<std::size_t>(Fault::silent)], 0u);
}

TEST_F(DeviceIntakeTest, ChannelsThatGoStaleTogetherAreOneLine) {
  link.state(-1, DWELL_FAULT_TIMEOUT, "no answer within 0.1 s");
  link.count(DWELL_FAULT_TIMEOUT);
  intake->take(now_ns);
  EXPECT_EQ(log.lines(), std::vector<std::string>{"warning device a: y0, y1 stale, timeout: no answer within 0.1 s"});
}

}  // namespace
}  // namespace dwell
