// What windows show of the transient: whose readings are used, when they are taken anew, what they are judged by.
#include "core/dwell/settling_windows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/transient/settling.hpp"
#include "tests/core/table_and_mass.hpp"

namespace dwell {
namespace {

constexpr double kWindowsHz = 4.0, kWindowsNoise = 1e-3;

// A table with an amplitude of 1, and a mass behind it whose own oscillation dies away.
struct WindowsBench {
  explicit WindowsBench(double of_transient = 0.0, double mass_rate_hz = 200.0)
      : transient(of_transient), mass_every(static_cast<long>(std::lround(200.0 / mass_rate_hz))) {
    data.open(0);
    windows.begin_hold();
  }
  // On to that instant, all windows looked at; whether the newest could be judged.
  bool run_to(double end_s) {
    bool judged = false;
    for (; static_cast<double>(readings) / 200.0 < end_s; ++readings) {
      const double t_s = static_cast<double>(readings) / 200.0;
      now_ns = std::llround(1e9 * t_s);
      while (now_ns >= data.blocks().open_end_ns()) {
        const std::int64_t end_ns = data.blocks().open_end_ns();
        data.close();
        data.take_block(end_ns);
        judged = look();
        data.open(end_ns);
      }
      const double phase = kTwoPi * kWindowsHz * t_s;
      read(0, std::sin(phase));
      if (readings % mass_every == 0)
        read(1, 2.0 * std::sin(phase - 1.0) + transient * std::exp(-t_s) * std::sin(kTwoPi * 2.3 * t_s));
    }
    return judged;
  }
  bool look() {
    const int quarters = kQuarters * windows.length().periods(), newest = data.blocks().count();
    if (newest < quarters) return false;
    const auto learn = [&](int, double squares, double freedom) { return freedom > 0 ? squares / freedom : INFINITY; };
    for (int to = windows.first_end(0); to <= newest; ++to) {
      if (!windows.look(to - quarters, to, now_ns, learn)) return false;
      verdict = windows.judge(to - quarters, to, 1e-9 * static_cast<double>(now_ns), 1.0);
    }
    return true;
  }
  void read(std::uint16_t c, double value) {
    Record record;
    record.t_ns = now_ns;
    record.value = value + std::normal_distribution<double>(0.0, kWindowsNoise)(random);
    record.channel = c;
    live.sample(record, data.omega(), [&](LiveChannel& channel, const LiveChannel::Reading& reading) {
      data.add(c, reading.t_ns, channel.count(reading));
    });
  }

  Rig rig = table_and_mass();
  double transient;
  long mass_every;
  LiveChannels live{rig};
  DriveReference reference{rig};
  CountedData data{rig, live, reference};
  SettlingWindows windows{rig, live, data};
  SettlingDetector::Verdict verdict;
  std::mt19937_64 random{1};
  long readings = 0;
  std::int64_t now_ns = 0;
};

TEST(SettlingWindows, OfASteadyRigAgreeAndTellTheMotionRelativeToTheTable) {
  WindowsBench bench;
  EXPECT_TRUE(bench.run_to(8.0));
  EXPECT_TRUE(bench.verdict.settled);
  EXPECT_TRUE(bench.windows.usable(0) && bench.windows.usable(1));
  EXPECT_NEAR(std::abs(bench.windows.phasor(1)), 2.0, 1e-2);
  EXPECT_NEAR(std::arg(bench.windows.phasor(1)), -1.0, 1e-2);
}

TEST(SettlingWindows, ATransientInOneChannelIsFoundThere) {
  WindowsBench bench(1.0);
  bench.run_to(3.0);
  EXPECT_FALSE(bench.verdict.settled);
  EXPECT_EQ(bench.verdict.worst_channel, 1);
  EXPECT_GT(bench.verdict.worst_left, 1.0);
}

TEST(SettlingWindows, AreTakenAnewWhenTheFrequencyHasMovedByWhatShows) {
  WindowsBench bench;
  bench.run_to(3.0);
  const int newest = bench.data.blocks().count();
  EXPECT_EQ(bench.windows.first_end(0), newest);
  bench.data.take_omega(kTwoPi * kWindowsHz * (1 + 0.3 * bench.rig.tolerance));
  EXPECT_EQ(bench.windows.first_end(0), kQuarters);
  EXPECT_EQ(bench.windows.first_end(0), newest) << "they are, from now on";
}

TEST(SettlingWindows, AChannelWithTooFewSamplesInOnePeriodMakesThemTwoPeriodsLong) {
  WindowsBench bench(0.0, 20.0);
  EXPECT_EQ(bench.windows.length().periods(), 1);
  bench.run_to(2.0);
  EXPECT_EQ(bench.windows.length().periods(), 2);
  bench.run_to(8.0);
  EXPECT_TRUE(bench.windows.usable(1));
}

TEST(SettlingWindows, AChannelThatDoesNotDeliverIsNotUsed) {
  WindowsBench bench;
  bench.run_to(2.0);
  EXPECT_TRUE(bench.windows.usable(1));
  bench.live[1].tell(Fault::timeout);
  bench.mass_every = 1'000'000;
  bench.run_to(2.3);
  EXPECT_FALSE(bench.windows.usable(1));
  EXPECT_TRUE(bench.windows.usable(0));
}

TEST(SettlingWindows, TheChainIsIdentifiedEachTimeTheHoldHasGrownByAThirtieth) {
  WindowsBench bench;
  bench.run_to(16.1);
  EXPECT_TRUE(bench.windows.wants_chain(0));
  EXPECT_FALSE(bench.windows.wants_chain(0));
  bench.run_to(16.3);
  EXPECT_FALSE(bench.windows.wants_chain(0));
  bench.run_to(17.0);
  EXPECT_TRUE(bench.windows.wants_chain(0));
}

// The transient decays with a time constant of 1000 periods. In one period it changes by a hundredth of the allowed
// size, so neighbouring windows agree while ten times the allowed size is left.
TEST(SettlingDetector, AWindowWithoutTheChannelDoesNotTellThatNothingIsLeft) {
  constexpr double kT_s = 1000.0, kPeriod_s = 1.0;
  struct Lost {
    int from, until;  // windows
  };
  for (const Lost lost : {Lost{0, 1}, Lost{5, 10}}) {
    SettlingDetector detector(1, 1e-3);
    for (int k = 0; k < 60; ++k) {
      const double t_s = kPeriod_s * (1 + 0.25 * k);
      SettlingDetector::Reading reading;
      reading.relative = 1.0 + 0.01 * std::exp(-t_s / kT_s);
      reading.u = 1e-7;
      reading.noise = reading.variance = 1e-14;
      reading.samples = 100;
      reading.usable = k < lost.from || k >= lost.until;
      const auto verdict = detector.update(k, k + 3, t_s, 1.0, 1e-7, {&reading, 1}, kPeriod_s, kT_s);
      EXPECT_FALSE(verdict.settled && reading.usable) << "lost from " << lost.from << ", window " << k;
    }
  }
}

}  // namespace
}  // namespace dwell
