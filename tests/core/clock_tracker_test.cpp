#include "core/stream/clock_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dwell {
namespace {

constexpr std::int64_t kTrackBegin_ns = 4'000'000'000;
constexpr double kTrackPeriod_ns = 1e6;

// A tracker that begins on a grid of 64 arrivals whose period is off by so many parts, and the arrivals that follow.
struct Followed {
  explicit Followed(double off = 0.0, double nominal_ns = 0.0) {
    ArrivalGrid grid;
    grid.period_ns = kTrackPeriod_ns * (1.0 + off);
    grid.last_ns = 63 * kTrackPeriod_ns;
    grid.spread = 0.01;
    tracker.begin(grid, kTrackBegin_ns, 64, nominal_ns);
  }
  [[nodiscard]] std::int64_t arrival_ns(double number) const {
    return kTrackBegin_ns + std::llround(number * true_period_ns);
  }
  // So many readings, each late by a normal jitter of so many periods.
  void run(int readings, double jitter) {
    std::normal_distribution<double> normal;
    for (int i = 0; i < readings; ++i, ++next) tracker.follow(arrival_ns(next + jitter * normal(rng)));
  }
  ClockTracker tracker;
  double next = 64, true_period_ns = kTrackPeriod_ns;
  std::mt19937_64 rng{1};
};

TEST(ClockTracker, ExactArrivalsAreFollowedExactly) {
  Followed device;
  device.run(1000, 0.0);
  EXPECT_EQ(device.tracker.t_ns(), device.arrival_ns(1063));
  EXPECT_NEAR(device.tracker.period_ns(), kTrackPeriod_ns, 1e-6);
  EXPECT_NEAR(device.tracker.deviation(device.arrival_ns(1064), 1), 0.0, 1e-6);
  EXPECT_NEAR(device.tracker.deviation(device.arrival_ns(1064.25), 1), 0.25, 1e-6);
  EXPECT_NEAR(device.tracker.deviation(device.arrival_ns(1070), 7), 0.0, 1e-6);
}

TEST(ClockTracker, AGuessOfThePeriodThatIsOffIsPutRight) {
  Followed device(1e-5);
  device.run(20'000, 0.02);
  EXPECT_NEAR(device.tracker.period_ns() / kTrackPeriod_ns, 1.0, 1e-6);
}

TEST(ClockTracker, TheStatedWidthCoversTheInstantAndShrinksWithAge) {
  int covered = 0;
  double young_ns = 0.0, old_ns = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Followed device;
    device.rng.seed(seed);
    device.run(100, 0.0125);
    young_ns += device.tracker.half_ns() / 100;
    device.run(5000, 0.0125);
    old_ns += device.tracker.half_ns() / 100;
    const double off_ns = static_cast<double>(device.tracker.t_ns() - device.arrival_ns(device.next - 1));
    if (std::abs(off_ns) <= device.tracker.half_ns()) ++covered;
  }
  // √3 standard deviations: 92 of 100 of a normal error.
  EXPECT_GE(covered, 84);
  EXPECT_LT(old_ns, 0.3 * young_ns);
}

TEST(ClockTracker, AStallDoesNotMoveTheClock) {
  Followed device;
  device.run(1000, 0.01);
  const double period_ns = device.tracker.period_ns();
  const double late = device.tracker.follow(device.arrival_ns(device.next + 5.0));
  EXPECT_NEAR(late, 5.0, 0.02);
  EXPECT_EQ(device.tracker.period_ns(), period_ns);
  EXPECT_NEAR(static_cast<double>(device.tracker.t_ns() - device.arrival_ns(device.next)), 0.0, 0.01 * kTrackPeriod_ns);
}

TEST(ClockTracker, LostReadingsMoveTheInstantByTheirPeriods) {
  Followed device;
  device.run(1000, 0.0);
  device.tracker.shift(3);
  device.next += 3;
  EXPECT_NEAR(device.tracker.deviation(device.arrival_ns(device.next), 1), 0.0, 1e-6);
  device.tracker.shift(-3);
  EXPECT_NEAR(device.tracker.deviation(device.arrival_ns(device.next), 1), 3.0, 1e-6);
}

TEST(ClockTracker, TheJitterIsThatOfTheArrivals) {
  Followed device;
  device.run(60'000, 0.03);
  EXPECT_NEAR(device.tracker.jitter_ns(), 0.03 * kTrackPeriod_ns, 0.002 * kTrackPeriod_ns);
}

TEST(ClockTracker, AStatedPeriodBoundsTheRateUntilItIsDoubted) {
  Followed device(0.0, kTrackPeriod_ns);
  device.true_period_ns = kTrackPeriod_ns * (1.0 + 3 * kNominalRange);
  device.next = 64 * kTrackPeriod_ns / device.true_period_ns;
  EXPECT_FALSE(device.tracker.doubts_nominal());
  for (int i = 0; i < 40'000 && !device.tracker.doubts_nominal(); ++i) {
    device.run(1, 0.0);
    ASSERT_LE(device.tracker.period_ns(), kTrackPeriod_ns * (1.0 + kNominalRange) * (1.0 + 1e-12));
    // A clock that runs away has its arrivals rejected as stalls; these stay within reach.
    if (device.tracker.deviation(device.arrival_ns(device.next), 1) > 0.05) device.next -= 0.04;
  }
  EXPECT_TRUE(device.tracker.doubts_nominal());
}

}  // namespace
}  // namespace dwell
