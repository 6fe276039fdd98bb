// At which instants a register is refreshed that is read more often: recovered from the readings that show a new value.
#include "core/intake/refresh_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace dwell {
namespace {

constexpr double kPoll_s = 2e-3;
constexpr double kRests_s = 15.0;
constexpr int kRests = 8;

struct Seen {
  double worst_s = 0.0;            // of |instant - truth|
  double worst_half_s = 0.0;       // largest half width
  double least_half_s = INFINITY;  // smallest half width
  int outside = 0;                 // instants whose half width does not hold the truth
  int believed = 0, of = 0;        // instants that the clock gave, of so many
};

// Refreshes at rate_hz read every 2 ms; what the clock says of those after from_s. wander_ppm: of the period, over the
// whole. missed: part of the new values that nobody recognizes as new. No reading from gap_s on, for gap_length_s. From
// rest_s on every value is the same, for rest_length_s, and again every kRests_s, kRests times: the rig stands still.
struct Register {
  double rate_hz = 333.0, jitter_s = 0.0, poll_jitter_s = 0.0, wander_ppm = 0.0, missed = 0.0;
  double gap_s = INFINITY, gap_length_s = 0.1, rest_s = INFINITY, rest_length_s = 0.0;
  std::mt19937_64 rng{3};

  Seen watch(double from_s, double to_s) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    RefreshClock clock;
    Seen seen;
    double on_grid = 0.3 / rate_hz, next = on_grid, truth = 0.0, read_before = 0.0;
    for (int i = 1; kPoll_s * i < to_s; ++i) {
      const double read = kPoll_s * i + poll_jitter_s * uniform(rng);
      if (read > gap_s && read < gap_s + gap_length_s) continue;
      bool renewed = false;
      for (; next <= read; renewed = true) {
        truth = next;
        on_grid += (1 + 1e-6 * wander_ppm * on_grid / to_s) / rate_hz;
        next = on_grid + jitter_s * uniform(rng);
      }
      if (read > rest_s && read < rest_s + kRests * kRests_s && std::fmod(read - rest_s, kRests_s) < rest_length_s)
        renewed = false;
      if (renewed && 0.5 * (uniform(rng) + 1) >= missed) {
        const auto instant = clock.refreshed(std::llround(read_before * 1e9), std::llround(read * 1e9));
        const double off = std::abs(1e-9 * static_cast<double>(instant.t_ns) - truth), half = 1e-9 * instant.half_ns;
        if (read > from_s) {
          seen.worst_s = std::max(seen.worst_s, off);
          seen.worst_half_s = std::max(seen.worst_half_s, half);
          seen.least_half_s = std::min(seen.least_half_s, half);
          if (clock.believed()) ++seen.believed;
          ++seen.of;
          if (off > half + 2e-9) ++seen.outside;
        }
      }
      read_before = read;
    }
    return seen;
  }
};

TEST(RefreshClock, InstantsAreKnownToAPartOfThePollingIntervalWhateverTheRate) {
  for (const double rate_hz : {11.7, 25.07, 61.3, 199.3, 249.0, 333.0, 401.7, 480.0, 491.0, 496.0}) {
    const Seen seen = Register{.rate_hz = rate_hz}.watch(10, 40);
    EXPECT_EQ(seen.outside, 0) << rate_hz;
    EXPECT_LT(seen.worst_half_s, 0.1 * kPoll_s) << rate_hz;
    EXPECT_LT(seen.worst_s, 0.1 * kPoll_s) << rate_hz;
    EXPECT_EQ(seen.believed, seen.of) << rate_hz;
  }
}

TEST(RefreshClock, OfARateThatIsASimpleRatioOnlyTheIntervalIsKnownAndSaid) {
  const Seen every_other = Register{.rate_hz = 250.0}.watch(10, 40);
  EXPECT_EQ(every_other.outside, 0);
  EXPECT_NEAR(every_other.worst_half_s, 0.5 * kPoll_s, 0.02 * kPoll_s);
  const Seen two_of_three = Register{.rate_hz = 1e3 / 3}.watch(10, 40);
  EXPECT_EQ(two_of_three.outside, 0);
  EXPECT_NEAR(two_of_three.worst_half_s, 0.25 * kPoll_s, 0.05 * kPoll_s);
}

TEST(RefreshClock, JitterAndAWanderingRateAndMissedValuesStayWithinWhatIsSaid) {
  for (const double rate_hz : {25.07, 199.3, 333.0}) {
    const Seen jittering = Register{.rate_hz = rate_hz, .jitter_s = 1e-4}.watch(20, 60);
    EXPECT_EQ(jittering.outside, 0) << rate_hz;
    EXPECT_LT(jittering.worst_half_s, 0.3 * kPoll_s) << rate_hz;
    const Seen polled_unevenly = Register{.rate_hz = rate_hz, .poll_jitter_s = 5e-4}.watch(10, 40);
    EXPECT_EQ(polled_unevenly.outside, 0) << rate_hz;
    EXPECT_LT(polled_unevenly.worst_half_s, 0.1 * kPoll_s) << rate_hz;
    const Seen wandering = Register{.rate_hz = rate_hz, .wander_ppm = 5}.watch(20, 300);
    EXPECT_EQ(wandering.outside, 0) << rate_hz;
    EXPECT_LT(wandering.worst_half_s, 0.15 * kPoll_s) << rate_hz;
    const Seen missing = Register{.rate_hz = rate_hz, .missed = 0.05}.watch(10, 40);
    EXPECT_EQ(missing.outside, 0) << rate_hz;
    EXPECT_LT(missing.worst_half_s, 0.1 * kPoll_s) << rate_hz;
  }
}

// A Modbus timeout. At 333 Hz the clock counts on through the gap; at 250 Hz, where the instants are known to half of
// the period only, the newest value is within one period of its reading.
TEST(RefreshClock, AGapInPollingLeavesTheClockAsGoodAsItWas) {
  for (const double rate_hz : {25.07, 199.3, 250.0, 333.0, 480.0}) {
    const Register gap{.rate_hz = rate_hz, .gap_s = 20.0005};
    const Seen before = Register(gap).watch(19, 20), across = Register(gap).watch(20, 20.2),
               after = Register(gap).watch(20.2, 21.2);
    EXPECT_EQ(across.outside, 0) << rate_hz;
    EXPECT_EQ(across.believed, across.of) << rate_hz;
    EXPECT_LT(across.worst_half_s, std::max(1.2 * before.worst_half_s, 0.5 / rate_hz + 0.1 * kPoll_s)) << rate_hz;
    EXPECT_EQ(after.outside, 0) << rate_hz;
    EXPECT_NEAR(after.worst_half_s, before.worst_half_s, 0.2 * before.worst_half_s) << rate_hz;
  }
}

// Refreshed within the jitter of the first reading after the gap: whether that one shows yet cannot be told.
TEST(RefreshClock, AfterAGapARefreshAtTheVeryReadingIsNotTakenForAnother) {
  for (const double rate_hz : {333.0, 401.7}) {
    for (int k = 0; k < 400; ++k) {
      Register gap{.rate_hz = rate_hz, .jitter_s = 2.5e-5, .gap_s = 5.0005, .gap_length_s = 0.1 + kPoll_s * k};
      gap.rng.seed(static_cast<unsigned>(k) + 1);
      const Seen seen = gap.watch(5, gap.gap_s + gap.gap_length_s + 0.1);
      EXPECT_EQ(seen.outside, 0) << rate_hz << " Hz, " << gap.gap_length_s << " s";
      EXPECT_EQ(seen.believed, seen.of) << rate_hz << " Hz, " << gap.gap_length_s << " s";
    }
  }
}

TEST(RefreshClock, ARigThatStandsStillAgainAndAgainLeavesTheClockAsGoodAsItWas) {
  for (const double rate_hz : {25.07, 199.3, 250.0, 333.0}) {
    for (const double length_s : {0.2, 1.0, 5.0, 9.0}) {
      const Register rests{.rate_hz = rate_hz, .rest_s = 20.0005, .rest_length_s = length_s};
      const Seen before = Register(rests).watch(15, 20), across = Register(rests).watch(20, 140),
                 after = Register(rests).watch(155, 160);
      EXPECT_EQ(across.outside, 0) << rate_hz << " Hz, " << length_s << " s";
      EXPECT_EQ(after.outside, 0) << rate_hz << " Hz, " << length_s << " s";
      EXPECT_LE(after.worst_half_s, std::max(1.2 * before.worst_half_s, 0.1 * kPoll_s))
          << rate_hz << " Hz, " << length_s << " s";
    }
  }
}

TEST(RefreshClock, APeriodThatWandersAsFastAsACrystalMayStaysWithinWhatIsSaid) {
  for (const double rate_hz : {25.07, 199.3, 333.0}) {
    const Seen wandering = Register{.rate_hz = rate_hz, .wander_ppm = 27}.watch(20, 300);  // 0.09 ppm a second
    EXPECT_EQ(wandering.outside, 0) << rate_hz;
    EXPECT_EQ(wandering.believed, wandering.of) << rate_hz;
    EXPECT_LT(wandering.worst_half_s, 0.15 * kPoll_s) << rate_hz;
  }
}

TEST(RefreshClock, WithoutARateOfItsOwnARegisterIsKnownByItsTwoReadings) {
  const Seen irregular = Register{.rate_hz = 60.0, .jitter_s = 6e-3}.watch(10, 40);
  EXPECT_EQ(irregular.outside, 0);
  EXPECT_EQ(irregular.believed, 0);
  EXPECT_NEAR(irregular.least_half_s, 0.5 * kPoll_s, 2e-9);
}

}  // namespace
}  // namespace dwell
