// What comes too late, too early, or not at all: named, counted, and of no harm to the other devices.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "daemon/estimate/estimator.hpp"
#include "tests/daemon/one_mass_rig.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

// Two devices with one channel each, polled at 200 Hz of a steady 10 Hz.
struct UntimelyTest : testing::Test {
  UntimelyTest() {
    LogOptions quiet;
    quiet.console = false;
    log = std::move(*Log::make(quiet));
    rig.devices = {{"a"}, {"b"}};
    for (Channel& channel : rig.channels) {
      channel.name = "y" + std::to_string(channel.at);
      channel.device = channel.at;
    }
    const std::vector<DeviceFeed> devices{{&links[0], "modbus", 200.0}, {&links[1], "modbus", 200.0}};
    estimator.emplace(
        rig, devices, EstimatorOptions{}, *log, [] {}, now_ns);
  }
  void push(std::uint16_t channel, std::int64_t t_ns) {
    const double angle = 2.0 * std::numbers::pi * 10.0 * static_cast<double>(t_ns) * 1e-9;
    const dwell_sample sample{t_ns, 1e-3 * (channel == 0 ? std::sin(angle) : 1.5 * std::sin(angle - 0.4)), 1000,
                              channel, 0};
    links[channel].push(&sample, 1);
  }
  // 10 ms a turn; the readings of device b carry stamps by `late_ns` old.
  void go_on(std::int64_t for_ns, std::int64_t late_ns = 0, bool b_turns = true) {
    for (const std::int64_t end_ns = now_ns + for_ns; now_ns < end_ns;) {
      now_ns += 10 * kMs_ns;
      for (const std::int64_t age_ns : {6 * kMs_ns, 1 * kMs_ns}) {
        push(0, now_ns - age_ns);
        if (b_turns) push(1, now_ns - age_ns - late_ns);
      }
      links[0].turn(now_ns);
      if (b_turns) links[1].turn(now_ns);
      estimator->turn(now_ns, now_ns + 1);
    }
  }
  const Snapshot& latest() {
    estimator->refresh();
    return estimator->latest();
  }

  Rig rig = test::one_mass_rig();
  std::unique_ptr<Log> log;
  std::array<DeviceLink, 2> links{DeviceLink{"a", {0}, 4096, nullptr}, DeviceLink{"b", {1}, 4096, nullptr}};
  std::int64_t now_ns = 5'000 * kMs_ns;
  std::optional<Estimator> estimator;
};

TEST_F(UntimelyTest, AStampFarInTheFutureCostsNobodyElseASample) {
  go_on(3'000 * kMs_ns);
  push(1, now_ns + 3'600'000 * kMs_ns);
  go_on(3'000 * kMs_ns);
  const Snapshot& snapshot = latest();
  EXPECT_EQ(snapshot.channels[0].tally.dropped(), 0u);
  EXPECT_EQ(snapshot.channels[1].tally.ahead, 1u);
  EXPECT_EQ(snapshot.channels[1].tally.dropped(), 1u);
  EXPECT_EQ(snapshot.channels[1].gaps, 1u);
  EXPECT_EQ(snapshot.channels[1].fault, Fault::none);
  for (const ChannelView& channel : snapshot.channels)
    EXPECT_EQ(channel.tally.received, channel.tally.used + channel.tally.dropped() + channel.tally.queued);
}

TEST_F(UntimelyTest, AStampALittleInTheFutureCostsNobodyElseASample) {
  go_on(3'000 * kMs_ns);
  push(1, now_ns + 800 * kMs_ns);
  go_on(3'000 * kMs_ns);
  EXPECT_EQ(latest().channels[0].tally.dropped(), 0u);
}

TEST_F(UntimelyTest, AChannelOfWhichEveryReadingIsLateIsNotOk) {
  go_on(3'000 * kMs_ns);
  go_on(3'000 * kMs_ns, 500 * kMs_ns);
  EXPECT_EQ(latest().channels[0].fault, Fault::none);
  EXPECT_EQ(latest().channels[1].fault, Fault::untimely);
  EXPECT_NE(latest().channels[1].reason.find("too late to be put in order: the newest 5"), std::string::npos)
      << latest().channels[1].reason;
  EXPECT_NE(latest().channels[1].reason.find("100 ms are waited for"), std::string::npos);
  EXPECT_EQ(latest().devices[1].faults[static_cast<std::size_t>(Fault::untimely)], 1u);
  EXPECT_FALSE(latest().devices[1].up);
  go_on(1'000 * kMs_ns);
  EXPECT_EQ(latest().channels[1].fault, Fault::none);
  EXPECT_EQ(latest().channels[1].reason, "");
}

TEST_F(UntimelyTest, AChannelOfWhichEveryReadingIsStampedAheadIsNotOk) {
  go_on(3'000 * kMs_ns, -60'000 * kMs_ns);
  EXPECT_EQ(latest().channels[1].fault, Fault::untimely);
  EXPECT_NE(latest().channels[1].reason.find("ahead of the clock, the newest by 60.0 s"), std::string::npos)
      << latest().channels[1].reason;
  EXPECT_EQ(latest().channels[1].tally.used, 0u);
}

TEST_F(UntimelyTest, ADriverThatHangsTakesItsOwnChannelsAlone) {
  go_on(3'000 * kMs_ns);
  go_on(4'000 * kMs_ns, 0, false);
  EXPECT_EQ(latest().channels[0].fault, Fault::none);
  EXPECT_EQ(latest().channels[1].fault, Fault::silent);
  EXPECT_NE(latest().channels[1].reason.find("its driver hangs"), std::string::npos) << latest().channels[1].reason;
  go_on(500 * kMs_ns);
  EXPECT_EQ(latest().channels[1].fault, Fault::none);
}

// Counted while it runs, said once at its end; a healthy rig has no warning of it.
TEST_F(UntimelyTest, PollsThatBeganTooLateAreSaidOnceAtTheEnd) {
  const dwell_host host = links[1].host();
  go_on(10'000 * kMs_ns);
  ASSERT_EQ(latest().dwell.state, State::measuring);
  const std::uint64_t lines = log->stats().lines;
  for (RunEvent event; estimator->next_event(event);) {
  }
  for (int minute = 0; minute < 3; ++minute) {
    go_on(60'000 * kMs_ns);
    host.count(host.context, DWELL_FAULT_MISSED_DEADLINE, 100);
  }
  EXPECT_EQ(log->stats().lines, lines);
  estimator->finish(now_ns, now_ns);
  EXPECT_EQ(latest().devices[1].faults[static_cast<std::size_t>(Fault::missed_deadline)], 300u);
  EXPECT_EQ(log->stats().lines, lines + 1) << "the polls";
  std::vector<RunEvent::Kind> events;
  for (RunEvent event; estimator->next_event(event);) events.push_back(event.kind);
  EXPECT_EQ(events, (std::vector{RunEvent::Kind::dwell_finished, RunEvent::Kind::state_changed}));
}

// A state that finds the merger's queue full of samples waits for room.
TEST_F(UntimelyTest, AStateIsNotLostWhereTheQueueIsFull) {
  go_on(3'000 * kMs_ns);
  // All of them wait for device a, whose newest stamp lies 1 ms back.
  for (int turn = 0; turn < 14; ++turn) {
    for (int i = 0; i < 1000; ++i) push(1, now_ns - 1 * kMs_ns + 1000 * turn + i);
    links[0].turn(now_ns);
    links[1].turn(now_ns);
    estimator->turn(now_ns, now_ns);
  }
  ASSERT_GT(links[1].counters(0).read().overflow, 0u);
  // Its driver hangs: the state is the host's own, at this test's time.
  const std::int64_t hangs_since_ns = now_ns;
  links[1].turn(hangs_since_ns - 4'000 * kMs_ns);
  estimator->turn(now_ns, now_ns);
  for (int i = 0; i < 50; ++i) {  // less than what the pipeline itself takes for silence
    now_ns += 10 * kMs_ns;
    push(0, now_ns - 6 * kMs_ns);
    push(0, now_ns - 1 * kMs_ns);
    estimator->turn(now_ns, now_ns);
  }
  // What the pipeline knows, by its own words.
  ASSERT_FALSE(latest().dwell.phasors.empty());
  EXPECT_NE(latest().dwell.phasors[1].reason.find("stale"), std::string::npos) << latest().dwell.phasors[1].reason;
}

}  // namespace
}  // namespace dwell
