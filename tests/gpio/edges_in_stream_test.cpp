// Edges on their way into the one ordered stream.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "daemon/estimate/estimator.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

struct EdgesInStream : testing::Test {
  EdgesInStream() {
    LogOptions quiet;
    quiet.console = false;
    log = std::move(*Log::make(quiet));
    rig.masses = {2.0};
    rig.excitation.frequency_hz = 10.0;
    rig.excitation.search_low_hz = 9.8;
    rig.excitation.search_high_hz = 10.2;
    rig.excitation.minimum = 1e-5;
    rig.devices = {{"amplifier", 0.0, 0.0}};
    for (int at = 0; at < 2; ++at) {
      Channel channel;
      channel.name = "y" + std::to_string(at);
      channel.device = 0;
      channel.at = at;
      rig.channels.push_back(channel);
    }
    EstimatorOptions options;
    options.gpio = &edges;
    estimator.emplace(
        rig, std::vector<DeviceFeed>{{&link, "modbus", 100.0}}, options, *log, [] {}, now_ns);
  }
  // One turn every 10 ms, a scan in each; `heard`: the GPIO thread turns as well.
  void go_on(std::int64_t for_ns, bool heard = true) {
    for (const std::int64_t end_ns = now_ns + for_ns; now_ns < end_ns;) {
      now_ns += 10 * kMs_ns;
      const double angle = 20.0 * std::numbers::pi * static_cast<double>(now_ns) * 1e-9;
      const dwell_sample samples[2] = {{now_ns - kMs_ns, 1e-3 * std::sin(angle), 1000, 0, 0},
                                       {now_ns - kMs_ns, 2e-3 * std::sin(angle - 0.4), 1000, 1, 0}};
      link.push(samples, 2);
      if (heard) edges.seen_to(now_ns - 10 * kMs_ns);
      estimator->turn(now_ns, now_ns + 1);
    }
  }
  void edge(Line line, std::int64_t t_ns) {
    Record record;
    record.kind = Kind::edge;
    record.channel = static_cast<std::uint16_t>(line);
    record.value = 1.0;
    record.t_ns = t_ns;
    ASSERT_TRUE(edges.push(record));
  }
  Tally tally() {
    estimator->refresh();
    return estimator->latest().channels[0].tally;
  }

  Rig rig;
  std::unique_ptr<Log> log;
  DeviceLink link{"amplifier", {0, 1}, 4096, nullptr};
  gpio::Link edges;
  std::int64_t now_ns = 5'000 * kMs_ns;
  std::optional<Estimator> estimator;
};

TEST_F(EdgesInStream, QuietLinesKeepNothingBack) {
  go_on(5'000 * kMs_ns);
  EXPECT_EQ(estimator->latest().dwell.state, State::idle) << "not refreshed yet";
  EXPECT_EQ(tally().dropped(), 0u);
  EXPECT_LE(tally().queued, 6u) << "a few turns' worth, not the 100 ms that a silent source may take";
  EXPECT_EQ(estimator->latest().dwell.state, State::measuring);
}

TEST_F(EdgesInStream, AGpioThreadThatStallsDelaysTheStreamButDoesNotStopIt) {
  go_on(1'000 * kMs_ns);
  go_on(3'000 * kMs_ns, false);
  EXPECT_EQ(tally().dropped(), 0u);
  EXPECT_LE(tally().queued, 15u);
}

TEST_F(EdgesInStream, APulseTooLateIsDroppedAndCountedTheInterlockIsNot) {
  go_on(1'000 * kMs_ns);
  edge(Line::sync, now_ns - 500 * kMs_ns);
  edge(Line::interlock, now_ns - 500 * kMs_ns);
  go_on(100 * kMs_ns);
  EXPECT_EQ(edges.late_edges(), 1u);
}

}  // namespace
}  // namespace dwell
