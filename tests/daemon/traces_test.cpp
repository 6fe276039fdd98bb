// Traces in virtual time: what is kept, how fine, and where a trace breaks.
#include "daemon/traces/traces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/rig/transducer.hpp"
#include "daemon/traces/trace_feed.hpp"
#include "tests/daemon/one_mass_rig.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kStart_ns = 5'000 * kMs_ns;
constexpr double kPi = std::numbers::pi;

Rig two_channels() {
  Rig rig = test::one_mass_rig();
  rig.channels[0].scale = 2.0;  // raw 1 is 2 of the unit, less 1
  rig.channels[0].offset = -1.0;
  rig.channels[1].range.low = -5.0;
  rig.channels[1].range.high = 5.0;
  return rig;
}

struct TracesTest : testing::Test {
  void sample(double t_s, double raw, std::uint16_t channel = 0, std::uint8_t flags = 0) {
    traces.take({.t_ns = at(t_s), .value = raw, .channel = channel, .kind = Kind::sample, .flags = flags});
  }
  void tick(double t_s) { traces.take({.t_ns = at(t_s), .kind = Kind::tick}); }
  static std::int64_t at(double t_s) { return kStart_ns + std::llround(t_s * 1e9); }
  // Channel 0 reads the time in seconds, 100 times a second, between these instants.
  void run(double from_s, double to_s) {
    for (std::int64_t i = std::llround(from_s * 100); i < std::llround(to_s * 100); ++i) {
      const double t_s = static_cast<double>(i) / 100.0;
      sample(t_s, (t_s + 1.0) / 2.0);
    }
  }
  [[nodiscard]] std::vector<TraceBin> read(double from_s, double to_s, std::int64_t points, std::size_t channel = 0) {
    stretch = traces.stretch(from_s, to_s, points);
    return traces.read(stretch, channel);
  }

  Rig rig = two_channels();
  Traces traces{rig};
  Traces::BinRange stretch;
};

TEST_F(TracesTest, ABinHoldsTheLeastAndTheGreatestReadingInTheChannelsUnit) {
  tick(0.0);
  for (const double raw : {1.0, 3.0, 2.0}) sample(0.005, raw);
  sample(0.025, 4.0);
  tick(1.0);
  const auto bins = read(0.0, 1.0, 51);
  ASSERT_EQ(stretch.step_ns, 20 * kMs_ns);
  EXPECT_EQ(bins[0].low, 1.0F);
  EXPECT_EQ(bins[0].high, 5.0F);
  EXPECT_EQ(bins[1].low, 7.0F);
  EXPECT_TRUE(bins[2].empty());
  EXPECT_FALSE(bins[2].broken) << "a slow channel has bins without a reading, and none is missing";
}

TEST_F(TracesTest, TheWidthIsTheFinestThatFitsTheNumberOfPoints) {
  run(0.0, 100.0);
  for (const auto& [range_s, step_us] : std::vector<std::pair<double, std::int64_t>>{
           {0.2, 313}, {1.0, 1'250}, {4.0, 5'000}, {19.0, 20'000}, {70.0, 80'000}, {99.0, 320'000}}) {
    (void)read(0.0, range_s, 1000);
    EXPECT_NEAR(static_cast<double>(stretch.step_ns) / 1e3, static_cast<double>(step_us), 1.0) << range_s;
  }
}

TEST_F(TracesTest, WiderBinsHoldWhatTheNarrowOnesHold) {
  run(0.0, 700.0);
  for (const std::int64_t points : {40'000, 9'000, 3'000, 600, 100}) {
    const auto bins = read(60.0, 660.0, points);
    for (std::size_t i = 0; i < bins.size(); ++i) {
      const double from_s =
          static_cast<double>((stretch.first + static_cast<std::int64_t>(i)) * stretch.step_ns) * 1e-9;
      const double width_s = static_cast<double>(stretch.step_ns) * 1e-9;
      if (from_s + width_s > 660.0) break;
      ASSERT_NEAR(bins[i].low, from_s, 0.0101) << points;
      ASSERT_NEAR(bins[i].high, from_s + width_s, 0.0101) << points;
    }
  }
}

TEST_F(TracesTest, TenMinutesAreKeptToTwentyMilliseconds) {
  run(0.0, 2000.0);
  const auto bins = read(2000.0 - 650.0, 1999.9, 32'600);
  EXPECT_EQ(stretch.step_ns, 20 * kMs_ns);
  EXPECT_NEAR(bins.front().low, 1350.0, 0.03);
  for (const TraceBin& bin : bins) ASSERT_FALSE(bin.empty());
}

TEST_F(TracesTest, WhatIsOlderIsKeptInWiderBinsAndThenCutOff) {
  run(0.0, 2000.0);
  (void)read(100.0, 200.0, 4000);
  EXPECT_EQ(stretch.step_ns, 80 * kMs_ns);
  tick(20'000.0);  // longer than anything is kept
  const auto bins = read(0.0, 20'000.0, 4000);
  EXPECT_NEAR(static_cast<double>(stretch.first * stretch.step_ns) * 1e-9, 20'000.0 - 32'768 * 0.32, 1.28);  // one bin
  for (const TraceBin& bin : bins) ASSERT_TRUE(bin.empty());
}

TEST_F(TracesTest, ATraceBreaksWhereReadingsAreMissingOrNotShown) {
  tick(0.0);
  for (int i = 0; i < 8; ++i) sample(0.02 * i + 0.01, 1.0, 1, i == 2 ? kGap : std::uint8_t{0});
  sample(0.17, 9.0, 1);                                                                    // beyond its range
  sample(0.19, kNaN, 1);                                                                   // not finite
  traces.take({.t_ns = at(0.21), .channel = 1, .kind = Kind::channel_state, .flags = 2});  // a timeout
  traces.take({.t_ns = at(0.23), .channel = 1, .kind = Kind::channel_state, .flags = 0});  // it delivers again
  sample(0.25, 1.0, 1);
  traces.withhold(1, true);
  sample(0.27, 1.0, 1);
  traces.withhold(1, false);
  sample(0.29, 1.0, 1);
  traces.lost();
  for (const std::int64_t points : {100, 20}) {  // of readings, and as kept
    std::vector<int> broken;
    const auto bins = read(0.0, 0.29, points, 1);
    for (std::size_t i = 0; i < bins.size(); ++i)
      if (bins[i].broken)
        broken.push_back(static_cast<int>(static_cast<std::int64_t>(i) * stretch.step_ns / (20 * kMs_ns)));
    EXPECT_EQ(broken, (std::vector<int>{2, 8, 9, 10, 12, 13, 14})) << stretch.step_ns;  // 12: after a pause
  }
  const auto bins = read(0.0, 0.29, 20, 1);
  EXPECT_TRUE(bins[8].empty()) << "a reading beyond its range is not drawn";
  EXPECT_FALSE(bins[2].empty()) << "the reading after a loss is";
}

// Of the bins of 20 ms, the numbers of those that are broken.
std::vector<int> broken(const std::vector<TraceBin>& bins) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < bins.size(); ++i)
    if (bins[i].broken) numbers.push_back(static_cast<int>(i));
  return numbers;
}

TEST_F(TracesTest, ATraceBreaksWhereReadingsPauseThoughNobodyTellsOfALoss) {
  tick(0.0);
  for (int i = 0; i < 10; ++i) sample(0.02 * i + 0.01, 1.0);
  sample(0.23, 1.0);                                             // one reading is missing
  for (const double t_s : {0.31, 0.33, 0.35}) sample(t_s, 1.0);  // three were
  EXPECT_EQ(broken(read(0.0, 0.35, 20)), std::vector<int>{15});
  EXPECT_EQ(broken(read(0.0, 0.35, 100)).size(), 1U) << "of readings";
}

TEST_F(TracesTest, AChannelWhoseReadingsComeInBurstsSoonBreaksNoMore) {
  tick(0.0);
  for (int i = 0; i < 320; ++i) sample(0.1 * (i / 16) + 0.001 * (i % 16), 1.0);
  EXPECT_EQ(broken(read(0.0, 2.0, 101)), (std::vector<int>{5, 10})) << "after the second burst their pace is known";
}

TEST_F(TracesTest, AReadingThatNoFloat32HoldsIsMissing) {
  tick(0.0);
  sample(0.01, 1.0);
  for (const double beyond : {1e39, -1e39}) sample(0.03, beyond);
  sample(0.05, 1e38);
  for (const std::int64_t points : {100, 3}) {  // of readings, and as kept
    const auto bins = read(0.0, 0.05, points);
    for (const TraceBin& bin : bins) {
      EXPECT_TRUE(bin.empty() || (std::isfinite(bin.low) && std::isfinite(bin.high))) << bin.low << " " << bin.high;
      EXPECT_TRUE(!bin.broken || bin.empty());
    }
    EXPECT_EQ(std::count_if(bins.begin(), bins.end(), [](const TraceBin& bin) { return bin.broken; }), 1);
  }
}

TEST_F(TracesTest, AStretchBeginsWithTheBinThatBeginsThen) {
  run(0.0, 100.0);
  for (int number = 0; number < 3000; ++number) {
    (void)read(0.02 * number, 99.0, 5000);
    ASSERT_EQ(stretch.step_ns, 20 * kMs_ns);
    ASSERT_EQ(stretch.first, number);
  }
}

TEST_F(TracesTest, ABinOfWhichReadingsAreNoLongerKeptIsBroken) {
  // More readings than are kept, 1000 a second: the oldest that is kept stands within a bin of 5 ms.
  const auto each = static_cast<std::int64_t>(
      std::min(TraceReadings::kMost, Traces::kReadingBytes / TraceReadings::kBytesEach / rig.channels.size()));
  for (std::int64_t i = 0; i < each + 10'003; ++i) sample(static_cast<double>(i) / 1000.0, 1.0);
  const double oldest_s = 10.003;
  auto bins = read(oldest_s, oldest_s + 1.0, 250);
  ASSERT_EQ(stretch.step_ns, 5 * kMs_ns);
  EXPECT_TRUE(bins[0].broken) << "of its five readings two are left";
  EXPECT_FALSE(bins[1].broken);
  tick(2000.01);  // bins of 80 ms are made of those of 20 ms or kept themselves
  bins = read(0.0, 2000.0, 200);
  EXPECT_FALSE(bins[0].broken) << "nothing has been overwritten in these";
  tick(20'000.01);
  bins = read(0.0, 20'000.0, 4000);
  EXPECT_TRUE(bins[0].broken);
  EXPECT_FALSE(bins[1].broken);
}

TEST_F(TracesTest, LessTheSteadyPartTheTransientIsLeft) {
  rig.channels[0] = rig.channels[1] = Channel{};
  rig.channels[1].measures = Quantity::acceleration;
  rig.channels[1].unit = "g";
  rig.channels[1].si_per_unit = 9.80665;
  rig.channels[1].delay_s = 0.002;
  rig.channels[1].lowpass = {FilterKind::butterworth, 2, 40.0, 0.0};
  traces = Traces(rig);
  Dwell dwell;
  dwell.index = 3;
  dwell.state = State::measuring;
  dwell.frequency_hz.value = 10.0;
  dwell.start_s = 1.0;
  dwell.settled_s = 5.0;
  dwell.t_ref_s = 6.0;
  dwell.phasors.resize(2);
  for (ChannelPhasor& phasor : dwell.phasors) {
    phasor.Y = std::polar(3.0, 0.7);
    phasor.mean = 0.5;
    phasor.valid = true;
  }
  // The run's axis begins 1 s after the traces'. Its readings, with a transient of 0.1 exp(-t).
  const std::int64_t origin_ns = at(1.0);
  for (int i = 0; i < 10'000; ++i) {
    const double t_s = 1e-3 * i, run_s = t_s - 1.0;
    for (std::uint16_t c = 0; c < 2; ++c) {
      const auto seen = dwell.phasors[c].Y * response(rig.channels[c], 0.0, 10.0);
      const double si = 0.5 + std::abs(seen) * std::sin(2 * kPi * 10.0 * (run_s - 6.0) + std::arg(seen));
      sample(t_s, (si + 0.1 * std::exp(-run_s)) / rig.channels[c].si_per_unit, c);
    }
  }
  const auto less = SteadyPart::of(dwell, rig, origin_ns);
  ASSERT_TRUE(less);
  const auto part = traces.stretch_of_readings(0.0, 9.9, 100);
  for (std::size_t c = 0; c < 2; ++c) {
    const auto bins = traces.read_less(part, c, *less);
    for (std::size_t i = 0; i < bins.size(); ++i) {
      const double t_s =
          static_cast<double>(part.first + static_cast<std::int64_t>(i)) * static_cast<double>(part.step_ns) * 1e-9;
      if (t_s < 2.0 - 0.33) {
        EXPECT_TRUE(bins[i].broken) << "the dwell had not begun at " << t_s;
      } else if (t_s >= 2.0) {
        EXPECT_NEAR(bins[i].high * rig.channels[c].si_per_unit, 0.1 * std::exp(-(t_s - 1.0)), 1e-6) << t_s;
      }
    }
  }
  dwell.settled_s = kNaN;
  EXPECT_FALSE(SteadyPart::of(dwell, rig, origin_ns)) << "what has not settled has no steady part";
}

TEST(TraceFeed, CountsWhatFindsNoRoomAndKeepsTheOrder) {
  TraceFeed feed;
  for (std::size_t i = 0; i < TraceFeed::kRecords + 5; ++i)
    feed.take({.t_ns = static_cast<std::int64_t>(i), .kind = Kind::tick});
  feed.take({.kind = Kind::fault});  // nothing that a trace is drawn from
  EXPECT_EQ(feed.lost(), 5U);
  std::int64_t next = 0;
  feed.drain([&](const Record& record) { EXPECT_EQ(record.t_ns, next++); });
  EXPECT_EQ(next, static_cast<std::int64_t>(TraceFeed::kRecords));
}

}  // namespace
}  // namespace dwell
