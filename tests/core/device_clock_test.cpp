#include "core/stream/device_clock.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <complex>
#include <string>

#include "tests/core/streaming_device.hpp"

namespace dwell {
namespace {

using Delay = StreamingDevice::Delay;

struct Stamped {
  double taken_s;
  std::int64_t arrival_ns;
  DeviceClock::Instant instant;
  bool locked;
  std::int64_t given_ns;  // when it was given out
};

// As the service does it: a look every 10 ms, and at every arrival.
std::vector<Stamped> recover(DeviceClock& clock, const std::vector<Arrival>& stream) {
  std::vector<Stamped> out;
  std::size_t given = 0;
  const auto take = [&](std::int64_t now_ns) {
    for (DeviceClock::Instant instant; clock.next(instant); ++given)
      out.push_back({stream[given].taken_s, stream[given].arrival_ns, instant, clock.figures().locked, now_ns});
  };
  std::int64_t look_ns = stream.empty() ? 0 : stream.front().arrival_ns;
  for (const Arrival& arrival : stream) {
    for (; look_ns < arrival.arrival_ns; look_ns += 10'000'000) {
      clock.wait(look_ns);
      take(look_ns);
    }
    clock.arrive(arrival.arrival_ns);
    take(arrival.arrival_ns);
  }
  clock.decide_all();
  take(look_ns);
  EXPECT_EQ(out.size(), stream.size()) << "every reading comes out once";
  return out;
}

// Total vector error of a sine of f, fitted with its mean over the readings from from_s on at the stamps given; the
// latency, a constant, apart.
template <class Stamp>
double vector_error(const std::vector<Stamped>& readings, double from_s, double f, const Stamp& stamp) {
  const double omega = 2.0 * M_PI * f;
  std::vector<double> latency;
  for (const Stamped& r : readings)
    if (r.taken_s > from_s) latency.push_back(stamp(r) - r.taken_s);
  const auto middle = latency.begin() + static_cast<std::ptrdiff_t>(latency.size() / 2);
  std::nth_element(latency.begin(), middle, latency.end());
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  for (const Stamped& r : readings) {
    if (r.taken_s <= from_s) continue;
    const double at = omega * (stamp(r) - *middle);
    const Eigen::Vector3d x(1.0, std::sin(at), std::cos(at));
    R += x * x.transpose();
    z += x * std::sin(omega * r.taken_s + 0.3);
  }
  const Eigen::Vector3d p = R.ldlt().solve(z);
  return std::abs(std::complex<double>(p[1], p[2]) - std::polar(1.0, 0.3));
}
double recovered(const Stamped& r) { return 1e-9 * static_cast<double>(r.instant.t_ns); }
double as_arrived(const Stamped& r) { return 1e-9 * static_cast<double>(r.arrival_ns); }

struct Errors {
  double recovered, as_arrived;  // 95th percentiles
};
// Ten-second dwells that begin warm_s after the device was switched on.
Errors dwells(const StreamingDevice& device, double rate_stated_hz, double warm_s, double f, int runs = 100) {
  std::vector<double> with, without;
  for (int run = 0; run < runs; ++run) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(run) + 1);
    DeviceClock clock(rate_stated_hz);
    const auto readings = recover(clock, arrivals(device, 1.0, 11.0 + warm_s, rng));
    with.push_back(vector_error(readings, 1.0 + warm_s, f, recovered));
    without.push_back(vector_error(readings, 1.0 + warm_s, f, as_arrived));
  }
  const auto percentile95 = [](std::vector<double>& errors) {
    std::sort(errors.begin(), errors.end());
    return errors[errors.size() * 95 / 100];
  };
  return {percentile95(with), percentile95(without)};
}

TEST(DeviceClock, AMillisecondOfJitterCostsLessThanAThousandthEvenFromTheFirstSampleOn) {
  for (const Delay delay : {Delay::uniform, Delay::exponential}) {
    StreamingDevice device;
    device.delay = delay;
    const Errors errors = dwells(device, 0.0, 0.0, 25.0, 200);
    EXPECT_LT(errors.recovered, 1e-3);
    EXPECT_GT(errors.as_arrived, 1.3e-3) << "as arrived it would cost more";
  }
}

TEST(DeviceClock, LostReadingsDoNotShiftThoseThatFollow) {
  for (const Delay delay : {Delay::uniform, Delay::exponential}) {
    StreamingDevice device;
    device.delay = delay;
    device.lost = 0.001;
    EXPECT_LT(dwells(device, 0.0, 3.0, 25.0).recovered, 1e-3);
    device.lost = 0.01;
    EXPECT_LT(dwells(device, 1000.0, 3.0, 25.0).recovered, 1e-3);
    // One in twenty, and a jitter as long as the period: where each was lost is known to a reading or two.
    device.lost = 0.05;
    EXPECT_LT(dwells(device, 1000.0, 3.0, 25.0).recovered, 4e-3);
  }
}

TEST(DeviceClock, AStallOfFiftyMillisecondsNowAndThenIsNotTakenForALoss) {
  for (const Delay delay : {Delay::uniform, Delay::exponential}) {
    StreamingDevice device;
    device.delay = delay;
    device.stall_every_s = 1.0;
    const Errors errors = dwells(device, 0.0, 3.0, 25.0);
    EXPECT_LT(errors.recovered, 1.5e-3);
    EXPECT_GT(errors.as_arrived, 0.03);
  }
}

// At few samples a second the wander of the recovered clock remains: the noise of the arrivals over the root of their
// number in its memory.
TEST(DeviceClock, ServesFastAndSlowDevices) {
  struct Case {
    double rate_hz, f, limit;
  };
  for (const Case c : {Case{50, 8, 1.5e-3}, Case{200, 25, 2e-3}, Case{500, 25, 1e-3}, Case{2000, 25, 1e-3}}) {
    StreamingDevice device;
    device.rate_hz = c.rate_hz;
    EXPECT_LT(dwells(device, 0.0, 3.0, c.f, 50).recovered, c.limit) << c.rate_hz;
    device.lost = 0.01;
    EXPECT_LT(dwells(device, c.rate_hz, 3.0, c.f, 50).recovered, c.limit) << c.rate_hz << ", losses";
  }
}

TEST(DeviceClock, TellsRateJitterAndLosses) {
  StreamingDevice device;
  device.off_ppm = 0.0;
  device.rate_hz = 1000.123;
  device.lost = 0.01;
  std::mt19937_64 rng(5);
  DeviceClock clock(1000.0);
  const auto readings = recover(clock, arrivals(device, 0.0, 40.0, rng));
  const ClockFigures figures = clock.figures();
  ASSERT_TRUE(figures.locked);
  EXPECT_NEAR(figures.rate_hz, 1000.123, 0.003);
  EXPECT_NEAR(figures.jitter_s, 1e-3 / std::sqrt(12.0), 1e-5);
  const double lost = 40.0 * 1000.123 - static_cast<double>(readings.size());
  EXPECT_NEAR(static_cast<double>(figures.lost), lost, 0.05 * lost) << "those before it locked are not counted";
  EXPECT_EQ(figures.relocked, 0u);
}

TEST(DeviceClock, FollowsARateThatWanders) {
  StreamingDevice device;
  device.wander_ppm = 2.0;  // as a quartz does whose oven breathes
  std::mt19937_64 rng(6);
  DeviceClock clock;
  double worst_s = 0.0;
  for (const Stamped& r : recover(clock, arrivals(device, 0.0, 150.0, rng)))
    if (r.taken_s > 30.0) worst_s = std::max(worst_s, std::abs(recovered(r) - r.taken_s - 0.6e-3));
  EXPECT_LT(worst_s, 3e-5);
}

TEST(DeviceClock, InstantsAdvanceAndStayNearTheArrival) {
  for (int run = 0; run < 40; ++run) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(100 + run));
    StreamingDevice device;
    device.rate_hz = run % 2 == 0 ? 300.0 : 1500.0;
    device.delay = run % 3 == 0 ? Delay::exponential : Delay::uniform;
    device.lost = run % 4 == 0 ? 0.05 : 0.0;
    device.stall_every_s = run % 5 == 0 ? 1.0 : 0.0;
    DeviceClock clock(run % 7 == 0 ? 0.0 : device.rate_hz);
    std::int64_t last_ns = 0;
    bool locked = false;
    for (const Stamped& r : recover(clock, arrivals(device, 1.0, 9.0, rng))) {
      // Until it is locked stamps stand, whatever they are.
      if (locked && r.locked) {
        ASSERT_GT(r.instant.t_ns, last_ns) << run;
      }
      ASSERT_LT(r.instant.t_ns - r.arrival_ns, 5'000'000) << run << ": in the future";
      ASSERT_LE(r.given_ns - r.arrival_ns, DeviceClock::kLongestHold_ns + 10'000'000) << run;
      last_ns = r.instant.t_ns;
      locked = r.locked;
    }
  }
}

TEST(DeviceClock, NothingJumpsWhenItLocks) {
  for (int run = 0; run < 20; ++run) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(200 + run));
    DeviceClock clock;
    double sum_s = 0.0;
    int count = 0;
    for (const Stamped& r : recover(clock, arrivals({}, 0.0, 1.0, rng))) {
      if (!r.locked || count == 50) continue;
      sum_s += recovered(r) - r.taken_s;
      ++count;
    }
    ASSERT_EQ(count, 50);
    EXPECT_NEAR(sum_s / count, 0.6e-3, 0.15e-3) << "the mean delay, which the arrivals have as well";
  }
}

TEST(DeviceClock, IsFoundAnewAfterTheDeviceWasRestarted) {
  std::mt19937_64 rng(7);
  auto stream = arrivals({}, 0.0, 5.0, rng);
  const auto again = arrivals({}, 7.0, 12.0, rng);  // another phase, another rate
  stream.insert(stream.end(), again.begin(), again.end());
  DeviceClock clock;
  double worst_s = 0.0;
  for (const Stamped& r : recover(clock, stream))
    if (r.taken_s > 9.0) worst_s = std::max(worst_s, std::abs(recovered(r) - r.taken_s - 0.6e-3));
  EXPECT_EQ(clock.figures().relocked, 1u);
  EXPECT_LT(worst_s, 1e-4);
}

TEST(DeviceClock, AStatedRateThatIsWrongIsGivenUp) {
  std::mt19937_64 rng(8);
  StreamingDevice device;
  device.delay = Delay::exponential;
  device.rate_hz = 1008.0;  // eight thousandths beside what is stated
  DeviceClock clock(1000.0);
  (void)recover(clock, arrivals(device, 0.0, 60.0, rng));
  ASSERT_TRUE(clock.figures().locked);
  EXPECT_NEAR(clock.figures().rate_hz, 1008.0, 0.3);
}

TEST(DeviceClock, AnIrregularSourceIsLeftAlone) {
  std::mt19937_64 rng(9);
  std::exponential_distribution<double> pause(1000.0);
  std::vector<Arrival> stream;
  double t_s = 0.0;
  for (int i = 0; i < 50'000; ++i) stream.push_back({t_s += pause(rng), std::llround(t_s * 1e9)});
  DeviceClock clock;
  for (const Stamped& r : recover(clock, stream)) {
    ASSERT_EQ(r.instant.t_ns, r.arrival_ns);
    ASSERT_EQ(r.instant.half_ns, 0u);
  }
  EXPECT_FALSE(clock.figures().locked);
  EXPECT_TRUE(std::isnan(clock.figures().rate_hz));
}

TEST(DeviceClock, StampsThatAreEvenAlreadyStayAsTheyAre) {
  std::vector<Arrival> stream;
  for (std::int64_t i = 0; i < 20'000; ++i)
    if (i % 97 != 0) stream.push_back({1e-3 * static_cast<double>(i), 1'000'000 * i});
  DeviceClock clock;
  for (const Stamped& r : recover(clock, stream)) ASSERT_NEAR(static_cast<double>(r.instant.t_ns - r.arrival_ns), 0, 2);
  EXPECT_TRUE(clock.figures().locked);
  EXPECT_NEAR(static_cast<double>(clock.figures().lost), 20'000 / 97.0, 5);
}

TEST(DeviceClock, WhatRemainsUncertainIsSaid) {
  std::mt19937_64 rng(10);
  int outside = 0, seen = 0;
  for (int run = 0; run < 100; ++run) {
    DeviceClock clock;
    const auto readings = recover(clock, arrivals({}, 0.0, 8.0, rng));
    const Stamped& last = readings.back();
    const double off_ns = static_cast<double>(last.instant.t_ns) - 1e9 * last.taken_s - 0.6e6;
    ++seen;
    if (std::abs(off_ns) > last.instant.half_ns) ++outside;
    EXPECT_LT(last.instant.half_ns, 50'000u);
  }
  // The half width is of a rectangle with the standard deviation of the clock: 8 % of a normal law lie outside.
  EXPECT_LT(outside, seen / 5);
}

TEST(DeviceClock, AFloodWithoutAnyTimeBetweenIsSurvived) {
  DeviceClock clock(1000.0);
  DeviceClock::Instant instant;
  for (int i = 0; i < 5000; ++i) {
    clock.arrive(1'000'000'000 + 1'000'000LL * std::min(i, 1000));
    while (clock.next(instant)) EXPECT_LE(instant.t_ns, 3'000'000'000);
  }
  clock.arrive(INT64_MAX / 2);
  clock.arrive(0);
  clock.decide_all();
  while (clock.next(instant)) {
  }
}

}  // namespace
}  // namespace dwell
