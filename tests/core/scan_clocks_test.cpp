#include "core/stream/scan_clocks.hpp"

#include <gtest/gtest.h>

#include <map>

#include "core/model/forward.hpp"
#include "core/stream/merger.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/streaming_device.hpp"

namespace dwell {
namespace {

Record scan_sample(std::int64_t t_ns, std::uint16_t channel, double value = 0.0) {
  Record record;
  record.t_ns = t_ns;
  record.channel = channel;
  record.value = value;
  return record;
}

std::vector<Record> drained(ScanClocks& clocks) {
  std::vector<Record> out;
  for (Record record; clocks.pop(record);) out.push_back(record);
  return out;
}

TEST(ScanClocks, ChannelsOfAScanKeepOneInstant) {
  std::mt19937_64 rng(1);
  ScanClocks clocks(Clock::device, {2, 5}, 0.0);
  std::vector<Record> out;
  for (const Arrival& arrival : arrivals({}, 0.0, 5.0, rng)) {
    clocks.push(scan_sample(arrival.arrival_ns, 2));
    clocks.push(scan_sample(arrival.arrival_ns, 5));
    for (const Record& record : drained(clocks)) out.push_back(record);
  }
  ASSERT_GT(out.size(), 9000u);
  int moved = 0;
  for (std::size_t i = 0; i + 1 < out.size(); i += 2) {
    ASSERT_EQ(out[i].channel, 2);
    ASSERT_EQ(out[i + 1].channel, 5);
    ASSERT_EQ(out[i].t_ns, out[i + 1].t_ns);
    if (i > 0) moved += std::llabs(out[i].t_ns - out[i - 2].t_ns - 1'000'000) < 50'000 ? 1 : 0;
  }
  EXPECT_GT(moved, 4500) << "and that is the recovered one";
}

TEST(ScanClocks, ReadingsOfOneBunchAreScansOfTheirOwn) {
  ScanClocks clocks(Clock::device, {0, 1}, 0.0);
  std::size_t count = 0;
  for (int i = 0; i < 300; ++i)
    for (std::uint16_t channel = 0; channel < 2; ++channel) {
      clocks.push(scan_sample(1'000'000LL * (i / 3 * 3), channel, i));
      count += drained(clocks).size();
    }
  clocks.flush();
  EXPECT_EQ(count + drained(clocks).size(), 600u);
}

TEST(ScanClocks, StreamsOfDifferentRatesHaveClocksOfTheirOwn) {
  ScanClocks clocks(Clock::device, {0, 1}, 1000.0);
  for (int i = 0; i < 20'000; ++i) {
    clocks.push(scan_sample(1'000'000LL * i, 0));
    if (i % 7 == 0) clocks.push(scan_sample(1'000'000LL * i + 300'000, 1));
    (void)drained(clocks);
  }
  EXPECT_NEAR(clocks.figures(0).rate_hz, 1000.0, 1e-3);
  EXPECT_NEAR(clocks.figures(1).rate_hz, 1000.0 / 7, 1e-3);
}

TEST(ScanClocks, WhereTheHostIsTheClockSamplesPassAtOnceUnchangedAndAreWatched) {
  std::mt19937_64 rng(2);
  ScanClocks clocks(Clock::host, {0, 1}, 1000.0);
  for (const Arrival& arrival : arrivals({}, 0.0, 5.0, rng)) {
    for (std::uint16_t channel = 0; channel < 2; ++channel) {
      clocks.push(scan_sample(arrival.arrival_ns, channel));
      const auto out = drained(clocks);
      ASSERT_EQ(out.size(), 1u);
      ASSERT_EQ(out[0].t_ns, arrival.arrival_ns);
      ASSERT_EQ(out[0].t_half_ns, 0u);
      ASSERT_EQ(out[0].flags, 0);
    }
  }
  EXPECT_NEAR(clocks.figures(1).jitter_s, 0.29e-3, 0.02e-3);
}

TEST(ScanClocks, EverySampleComesOutOnceAndInItsChannelsOrder) {
  for (int run = 0; run < 20; ++run) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(run));
    StreamingDevice device;
    device.lost = 0.05;
    device.stall_every_s = 0.5;
    ScanClocks clocks(Clock::device, {0, 1, 2}, 0.0);
    std::map<int, double> last;
    double pushed = 0, popped = 0;
    const auto take = [&] {
      for (const Record& record : drained(clocks)) {
        const auto [at, first] = last.try_emplace(record.channel, record.value);
        if (!first) {
          EXPECT_GT(record.value, std::exchange(at->second, record.value));
        }
        ++popped;
      }
    };
    for (const Arrival& arrival : arrivals(device, 0.0, 3.0, rng)) {
      // Channels come in any company: all of them, some, or none.
      for (std::uint16_t channel = 0; channel < 3; ++channel)
        if (rng() % 8 != 0) clocks.push(scan_sample(arrival.arrival_ns, channel, ++pushed));
      take();
      if (rng() % 50 == 0) clocks.wait(arrival.arrival_ns + 150'000'000);
    }
    clocks.flush();
    take();
    EXPECT_EQ(popped, pushed);
  }
}

// Two devices, each with a clock and a jitter of its own, one transducer on each: all the way to the phasors.
TEST(ScanClocks, PhasorsOfTwoDevicesAgreeToAThousandthAcrossThePipeline) {
  const double f = 25.0;
  const Chain chain = free_chain();
  const Drive drive{.frequency_hz = f, .amplitude = 0.002, .offset = 0, .ramp_s = 0, .harmonics = {}};
  for (int run = 0; run < 6; ++run) {
    Rig rig = rig_of(chain, f);
    DrivenChain motion(chain, drive, DrivenChain::Start::steady);
    Pipeline pipeline(rig);
    Merger merger(rig.channels.size(), ScanClocks::kHoldBack_ns, 4096);
    std::vector<ScanClocks> clocks;
    struct Due {
      Arrival arrival;
      std::uint16_t channel;
    };
    std::vector<Due> due;
    std::mt19937_64 rng(static_cast<std::uint64_t>(run) + 30);
    for (std::uint16_t c = 0; c < rig.channels.size(); ++c) {
      clocks.emplace_back(Clock::device, std::vector<std::uint16_t>{c}, 1000.0);
      for (const Arrival& arrival : arrivals({}, 0.0, 13.0, rng)) due.push_back({arrival, c});
    }
    std::stable_sort(due.begin(), due.end(),
                     [](const Due& a, const Due& b) { return a.arrival.arrival_ns < b.arrival.arrival_ns; });
    for (const Due& d : due) {
      const double value = exact_reading(rig, motion.at(d.arrival.taken_s), d.channel);
      clocks[d.channel].push(scan_sample(d.arrival.arrival_ns, d.channel, value));
      for (const Record& record : drained(clocks[d.channel]))
        ASSERT_EQ(merger.push(d.channel, record), Merger::Admission::queued);
      for (Record out; merger.pop(out);) pipeline.push(out);
    }
    const Dwell dwell = pipeline.current();
    ASSERT_EQ(dwell.state, State::measuring) << dwell.settling_reason;
    // A latency common to all turns every phasor alike.
    const std::vector<Phasor> exact = steady_response(chain, 2 * M_PI * f, 0.002).Y;
    for (std::size_t c = 1; c < rig.channels.size(); ++c) {
      const std::complex<double> ratio = dwell.phasors[c].Y / dwell.phasors[0].Y, truth = exact[c] / exact[0];
      EXPECT_LT(std::abs(ratio / truth - 1.0), 2e-3) << run;
    }
    EXPECT_NEAR(std::abs(dwell.phasors[0].Y) / 0.002, 1.0, 1e-3) << run;
  }
}

}  // namespace
}  // namespace dwell
