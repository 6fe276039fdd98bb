// The estimation in virtual time: what the drivers hand in, what the snapshots say.
#include "daemon/estimate/estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <random>

#include "tests/daemon/collecting_sink.hpp"
#include "tests/daemon/one_mass_rig.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kStart_ns = 5'000 * kMs_ns;

Rig one_mass() {
  Rig rig = test::one_mass_rig();
  rig.name = "one mass";
  rig.devices = {{"amplifier", 0.0, 0.0}};
  for (Channel& channel : rig.channels) {
    channel.name = "y" + std::to_string(channel.at);
    channel.device = 0;
    channel.unit = "mm";
    channel.si_per_unit = 1e-3;
    channel.range.low = -5.0;
    channel.range.high = 5.0;
  }
  return rig;
}

struct EstimatorTest : testing::Test {
  EstimatorTest() {
    LogOptions quiet;
    quiet.console = false;
    log = std::move(*Log::make(quiet));
    begin({});
  }
  void begin(const EstimatorOptions& options, bool leads = false) {
    estimator.emplace(
        rig, std::vector<DeviceFeed>{{&link, "modbus", 200.0, leads}}, options, *log, [this] { ++woken; }, now_ns);
  }
  // A scan of both channels stamped t; of a steady 10 Hz, in the channels' unit.
  bool scan(std::int64_t t_ns, double factor = 1.0) {
    const double angle = 2.0 * std::numbers::pi * 10.0 * static_cast<double>(t_ns) * 1e-9;
    const dwell_sample samples[2] = {{t_ns, factor * std::sin(angle), 1000, 0, 0},
                                     {t_ns, factor * 1.5 * std::sin(angle - 0.4), 1000, 1, 0}};
    return link.push(samples, 2);
  }
  // Goes on for so long, turning every 10 ms, with two scans in each turn where the device is `on`.
  void go_on(std::int64_t for_ns, bool on = true) {
    for (const std::int64_t end_ns = now_ns + for_ns; now_ns < end_ns;) {
      now_ns += 10 * kMs_ns;
      if (on) {
        scan(now_ns - 6 * kMs_ns);
        scan(now_ns - 1 * kMs_ns);
      }
      estimator->turn(now_ns, now_ns + 1);
    }
  }
  const Snapshot& latest() {
    estimator->refresh();
    return estimator->latest();
  }

  Rig rig = one_mass();
  std::unique_ptr<Log> log;
  DeviceLink link{"amplifier", {0, 1}, 4096, nullptr};
  std::int64_t now_ns = kStart_ns;
  int woken = 0;
  std::optional<Estimator> estimator;
};

TEST_F(EstimatorTest, PublishesAsOftenAsTheRigFileSays) {
  go_on(2'000 * kMs_ns);
  EXPECT_NEAR(static_cast<double>(latest().sequence), 20, 1);
  int events = 0;
  for (RunEvent event; estimator->next_event(event);) ++events;
  EXPECT_EQ(latest().sequence + static_cast<std::uint64_t>(events), static_cast<std::uint64_t>(woken));
}

TEST_F(EstimatorTest, MeasuresWhatSettles) {
  go_on(10'000 * kMs_ns);
  const Snapshot& snapshot = latest();
  EXPECT_EQ(snapshot.dwell.state, State::measuring) << snapshot.dwell.settling_reason;
  for (const ChannelView& channel : snapshot.channels) {
    EXPECT_EQ(channel.fault, Fault::none) << channel.reason;
    EXPECT_NEAR(channel.rate_hz, 200.0, 5.0);
    EXPECT_LE(std::fabs(channel.value), 1.5 + 1e-9) << "in the channel's own unit";
    EXPECT_EQ(channel.tally.received, channel.tally.used + channel.tally.dropped() + channel.tally.queued);
    EXPECT_EQ(channel.tally.dropped(), 0u);
    EXPECT_LE(channel.tally.queued, 22u) << "no more than what the merger holds back";
  }
}

TEST_F(EstimatorTest, TellsWhatTheStampsSayOfTheClockBehindThem) {
  rig.devices[0].rate_hz = 200.1;
  begin({});
  go_on(5'000 * kMs_ns);
  for (const ChannelView& channel : latest().channels) {
    EXPECT_EQ(channel.clock.kind, Clock::host);
    EXPECT_NEAR(channel.clock.rate_hz, 200.0, 1e-6);
    EXPECT_NEAR(channel.clock.drift_ppm, -499.75, 0.1);
    EXPECT_LT(channel.clock.jitter_s, 1e-6);
  }
}

TEST_F(EstimatorTest, ADeviceWithAClockOfItsOwnIsMeasuredAtItsInstants) {
  rig.devices[0].clock = Clock::device;
  begin({});
  std::mt19937_64 rng(1);
  std::uniform_int_distribution<std::int64_t> delay_ns(0, 2 * kMs_ns);
  for (std::int64_t i = 0; i < 2400; ++i) {  // two to a turn, up to 2 ms late
    const std::int64_t taken_ns = now_ns + (i % 2 == 0 ? 1 : 6) * kMs_ns;
    const double angle = 2.0 * std::numbers::pi * 10.0 * static_cast<double>(taken_ns) * 1e-9;
    const std::int64_t t_ns = taken_ns + delay_ns(rng);
    const dwell_sample samples[2] = {{t_ns, std::sin(angle), 0, 0, 0}, {t_ns, 1.5 * std::sin(angle - 0.4), 0, 1, 0}};
    ASSERT_TRUE(link.push(samples, 2));
    if (i % 2 == 0) continue;
    now_ns += 10 * kMs_ns;
    estimator->turn(now_ns, now_ns + 1);
  }
  const Snapshot& snapshot = latest();
  ASSERT_EQ(snapshot.dwell.state, State::measuring) << snapshot.dwell.settling_reason;
  // As they arrived, the jitter would take (2 π 10 · 0.58 ms)²/2 = 0.07 % off each amplitude.
  EXPECT_NEAR(std::abs(snapshot.dwell.phasors[0].Y), 1e-3, 1.5e-7);
  for (const ChannelView& channel : snapshot.channels) {
    EXPECT_EQ(channel.clock.kind, Clock::device);
    EXPECT_NEAR(channel.clock.rate_hz, 200.0, 0.01);
    EXPECT_NEAR(channel.clock.jitter_s, 0.58e-3, 0.05e-3);
    EXPECT_TRUE(std::isnan(channel.clock.drift_ppm)) << "no rate is stated";
    EXPECT_EQ(channel.tally.received, 2400u);
    EXPECT_EQ(channel.tally.received, channel.tally.used + channel.tally.dropped() + channel.tally.queued);
    EXPECT_EQ(channel.tally.dropped(), 0u);
  }
  estimator->finish(now_ns, now_ns + 1);
  EXPECT_EQ(latest().channels[0].tally.used, 2400u) << "what the clock held has been used";
}

TEST_F(EstimatorTest, SilenceIsNoticedSaidAndOver) {
  go_on(3'000 * kMs_ns);
  go_on(2'000 * kMs_ns, false);
  EXPECT_EQ(latest().channels[1].fault, Fault::silent);
  EXPECT_NE(latest().channels[1].reason.find("nothing received"), std::string::npos);
  EXPECT_FALSE(latest().devices[0].up);
  EXPECT_NE(latest().dwell.state, State::measuring);
  EXPECT_EQ(latest().channels[1].tally.queued, 0u) << "the rest has been used";
  go_on(500 * kMs_ns);
  EXPECT_EQ(latest().channels[1].fault, Fault::none);
  EXPECT_EQ(latest().channels[1].reason, "");
}

TEST_F(EstimatorTest, ADeadDeviceIsStaleForTheReasonItGave) {
  go_on(3'000 * kMs_ns);
  link.state(-1, DWELL_FAULT_DISCONNECTED, "connection refused");
  // The driver stamps with the real clock, long after this test's own time.
  go_on(200 * kMs_ns, false);
  EXPECT_EQ(latest().channels[0].fault, Fault::disconnected);
  EXPECT_EQ(latest().channels[0].reason, "connection refused");
}

TEST_F(EstimatorTest, ASampleFromBeforeWhatWasUsedIsLateAndCountedAndAGap) {
  go_on(1'000 * kMs_ns);
  scan(now_ns - 500 * kMs_ns);
  go_on(1'000 * kMs_ns);
  const Snapshot& snapshot = latest();
  for (const ChannelView& channel : snapshot.channels) {
    EXPECT_EQ(channel.tally.late, 1u);
    EXPECT_EQ(channel.tally.received, channel.tally.used + channel.tally.dropped() + channel.tally.queued);
    EXPECT_EQ(channel.gaps, 1u);
  }
}

// Whoever keeps the stream can account for every sample: received = in the stream + lost, by reason.
TEST_F(EstimatorTest, TheStreamBeginsAndEndsWithItsRunAndTellsOfEverySampleThatIsNotInIt) {
  test::CollectingSink sink;
  const std::vector<Record>& stream = sink.records;
  EstimatorOptions shown;
  shown.runs.sink = &sink;
  begin(shown);
  go_on(1'000 * kMs_ns);
  scan(now_ns - 500 * kMs_ns);    // late
  scan(now_ns + 5'000 * kMs_ns);  // stamped ahead
  link.count(DWELL_FAULT_TIMEOUT, 3);
  go_on(1'000 * kMs_ns);
  while (scan(now_ns)) {
  }
  ASSERT_TRUE(estimator->rearm());
  go_on(100 * kMs_ns);
  estimator->finish(now_ns, now_ns);

  const auto flagged = [&](const Record& record, Kind kind, auto flags) {
    return record.kind == kind && record.flags == static_cast<std::uint8_t>(flags);
  };
  EXPECT_TRUE(flagged(stream.front(), Kind::run, RunEdge::armed));
  EXPECT_TRUE(flagged(stream[1], Kind::run, RunEdge::begins));
  EXPECT_TRUE(flagged(stream.back(), Kind::run, RunEdge::ends));
  EXPECT_TRUE(
      std::is_sorted(stream.begin(), stream.end(), [](const Record& a, const Record& b) { return a.t_ns < b.t_ns; }));
  double in_stream = 0, timeouts = 0, actions = 0;
  std::map<Loss, double> lost;
  for (const Record& record : stream) {
    if (record.channel == 0 && record.kind == Kind::sample) ++in_stream;
    if (record.channel == 0 && record.kind == Kind::loss) lost[static_cast<Loss>(record.flags)] += record.value;
    if (flagged(record, Kind::fault, Fault::timeout)) timeouts += record.value;
    actions += flagged(record, Kind::action, Action::rearm);
  }
  const Tally tally = latest().channels[0].tally;
  EXPECT_EQ(lost[Loss::late], 1);
  EXPECT_EQ(lost[Loss::ahead], 1);
  EXPECT_GE(lost[Loss::refused], 1);
  EXPECT_EQ(lost[Loss::refused], static_cast<double>(tally.refused));
  EXPECT_EQ(static_cast<double>(tally.received),
            in_stream + lost[Loss::late] + lost[Loss::ahead] + lost[Loss::refused] + lost[Loss::overflow]);
  EXPECT_EQ(timeouts, 3);
  EXPECT_EQ(actions, 1);
}

TEST_F(EstimatorTest, TheStreamKeepsTheDriversStampBesideTheRecoveredOne) {
  rig.devices[0].clock = Clock::device;
  rig.devices[0].rate_hz = 200.0;
  test::CollectingSink sink;
  EstimatorOptions shown;
  shown.hold_back_ns = ScanClocks::kHoldBack_ns;
  shown.runs.sink = &sink;
  begin(shown);
  std::mt19937_64 random(7);
  std::uniform_int_distribution<std::int64_t> late_ns(0, 2 * kMs_ns);
  std::vector<std::int64_t> stamps;
  for (const std::int64_t end_ns = now_ns + 5'000 * kMs_ns; now_ns < end_ns;) {
    now_ns += 10 * kMs_ns;
    for (const std::int64_t before_ns : {8, 3}) {
      stamps.push_back(now_ns - before_ns * kMs_ns + late_ns(random));
      scan(stamps.back());
    }
    estimator->turn(now_ns, now_ns);
  }
  estimator->finish(now_ns, now_ns);
  std::vector<Record> samples;
  std::copy_if(sink.records.begin(), sink.records.end(), std::back_inserter(samples),
               [](const Record& record) { return record.kind == Kind::sample; });
  ASSERT_EQ(samples.size(), 2 * stamps.size());
  std::size_t moved = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].stamped_ns, stamps[i / 2]);
    moved += samples[i].t_ns != samples[i].stamped_ns;
  }
  EXPECT_GT(moved, samples.size() / 2) << "the clock was recovered";
}

TEST_F(EstimatorTest, WhatIsBeyondTheRangeIsShownAndNotUsed) {
  go_on(500 * kMs_ns);
  for (int i = 0; i < 40; ++i) {
    now_ns += 10 * kMs_ns;
    scan(now_ns - 1 * kMs_ns, 100.0);
    estimator->turn(now_ns, now_ns);
  }
  go_on(300 * kMs_ns, false);
  EXPECT_GT(latest().channels[0].tally.rejected, 0u);
  EXPECT_EQ(latest().channels[0].tally.received,
            latest().channels[0].tally.used + latest().channels[0].tally.dropped());
}

TEST_F(EstimatorTest, ABacklogIsNotLate) {
  go_on(1'000 * kMs_ns);
  // The thread did not come for a second and a half; the rings held everything.
  const std::int64_t paused_ns = now_ns;
  for (std::int64_t t = 5; t <= 1500; t += 5) ASSERT_TRUE(scan(paused_ns + t * kMs_ns - 1));
  now_ns = paused_ns + 1500 * kMs_ns;
  estimator->turn(now_ns, now_ns, 149);
  go_on(500 * kMs_ns);
  EXPECT_EQ(latest().channels[0].tally.late, 0u);
  EXPECT_EQ(latest().channels[0].gaps, 0u);
  EXPECT_EQ(latest().skipped_turns, 149u);
}

TEST_F(EstimatorTest, RearmEndsADwellAndBeginsAnotherAndOnlySoManyAreKept) {
  EstimatorOptions few;
  few.kept_dwells = 3;
  begin(few);
  for (int i = 0; i < 6; ++i) {
    go_on(4'000 * kMs_ns);
    ASSERT_TRUE(estimator->rearm());
    go_on(300 * kMs_ns);
  }
  const Snapshot& snapshot = latest();
  ASSERT_EQ(snapshot.finished->size(), 3u);
  EXPECT_EQ(snapshot.forgotten, 3u);
  EXPECT_LT(snapshot.finished->front()->index, snapshot.finished->back()->index) << "oldest first";
}

TEST_F(EstimatorTest, TheOperatorCannotFloodTheStream) {
  int taken = 0;
  for (int i = 0; i < 1000; ++i) taken += estimator->rearm() ? 1 : 0;
  EXPECT_LE(taken, 16);
  EXPECT_GE(taken, 1);
}

TEST_F(EstimatorTest, TheEndOfTheRunUsesWhatWaitsAndCompletesTheDwell) {
  go_on(8'000 * kMs_ns);
  scan(now_ns + 1 * kMs_ns);
  now_ns += 2 * kMs_ns;
  estimator->finish(now_ns, now_ns);
  const Snapshot& snapshot = latest();
  EXPECT_EQ(snapshot.channels[0].tally.queued, 0u);
  ASSERT_EQ(snapshot.finished->size(), 1u);
  EXPECT_EQ(snapshot.finished->front()->ended_by, EndedBy::end);
}

TEST_F(EstimatorTest, ARecordingPlayedFasterThanTimeIsUsedWhole) {
  begin({}, true);  // as the driver says of it
  // Ten seconds of stamps within one second.
  for (int i = 0; i < 100; ++i) {
    now_ns += 10 * kMs_ns;
    for (int k = 0; k < 20; ++k) scan(kStart_ns + (i * 20 + k + 1) * 5 * kMs_ns);
    estimator->turn(now_ns, now_ns);
  }
  estimator->finish(now_ns, now_ns);
  EXPECT_EQ(latest().channels[0].tally.used, 2000u);
  EXPECT_EQ(latest().channels[0].tally.dropped(), 0u);
}

}  // namespace
}  // namespace dwell
