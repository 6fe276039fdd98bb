// A drive that goes from one frequency to any other in a wide search range: the next dwell is at the new frequency.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kChangedAmplitude = 2e-3;

// Frequencies before and after, and the rig file's, Hz; readings a second; noise, as a part of the drive's amplitude.
struct DriveChange {
  double before_hz, after_hz, nominal_hz, rate_hz = 200.0, noise = 1e-3;
};

Rig widely_searched(const Chain& chain, double nominal_hz) {
  Rig rig = rig_of(chain, nominal_hz);
  rig.excitation.search_low_hz = 3.0;
  rig.excitation.search_high_hz = 8.0;
  rig.excitation.minimum = 1e-5;
  return rig;
}

Sampling uneven(double rate_hz, double noise) {
  return {.rate_hz = rate_hz, .jitter = 0.2, .sigma = std::vector<double>(3, noise * kChangedAmplitude)};
}

// What settling takes where the drive begins at rest, at the rig file's own frequency.
double settles_alone_s(const Chain& chain, const DriveChange& change, std::uint64_t seed) {
  Bench bench(chain, widely_searched(chain, change.after_hz), {change.after_hz, kChangedAmplitude},
              DrivenChain::Start::rest, uneven(change.rate_hz, change.noise), seed);
  bench.run(60, [&] { return bench.pipeline.state() == State::measuring; });
  return bench.now_s();
}

class ChangeOfDrive : public testing::TestWithParam<DriveChange> {};

TEST_P(ChangeOfDrive, IsFollowedAtOnceAndNeverAtAFalseFrequency) {
  const DriveChange& change = GetParam();
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 rng(100 + seed);
    const Chain chain = random_chain(rng, 2, Boundary::free, 5.0);
    const double alone_s = settles_alone_s(chain, change, seed);
    Bench bench(chain, widely_searched(chain, change.nominal_hz), {change.before_hz, kChangedAmplitude},
                DrivenChain::Start::steady, uneven(change.rate_hz, change.noise), seed);
    bench.run(10 + 0.037 * static_cast<double>(seed));  // the change comes at another phase in each
    ASSERT_EQ(bench.pipeline.state(), State::measuring) << seed;
    bench.set_drive({change.after_hz, kChangedAmplitude});
    const double changed_s = bench.now_s();
    bench.run(changed_s + 60, [&] { return !bench.dwells.empty() && bench.pipeline.state() == State::measuring; });
    // The dwell before ends as a change, and what follows is the drive as it is.
    ASSERT_EQ(bench.dwells.size(), 1u) << seed;
    EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::drive_changed) << seed;
    EXPECT_NEAR(bench.dwells[0].frequency_hz.value, change.before_hz, 1e-3 * change.before_hz) << seed;
    ASSERT_EQ(bench.pipeline.state(), State::measuring) << seed;
    EXPECT_NEAR(bench.pipeline.current().frequency_hz.value, change.after_hz, 0.01 * change.after_hz) << seed;
    // The transient is larger or smaller than after rest; 1.43 times as long is the most that was seen.
    EXPECT_LT(bench.now_s() - changed_s, 2 * alone_s) << seed;
    bench.run(bench.now_s() + 5);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 2u) << seed;
    const Estimate& seen = bench.dwells[1].frequency_hz;
    EXPECT_NEAR(seen.value, change.after_hz, 5 * seen.u) << seed;
  }
}

// A drive at rest tells nothing of the next: neither the frequency in the rig file nor the one before may hide it.
TEST(DriveAfterRest, IsFoundAnywhereInTheSearchRange) {
  for (const double hz : {3.1, 4.0, 5.9, 7.9}) {
    const Chain chain = free_chain();
    Bench bench(chain, widely_searched(chain, 4.0), {4.0, kChangedAmplitude}, DrivenChain::Start::steady,
                uneven(200.0, 1e-3));
    bench.run(8);
    bench.set_drive({4.0, 0.0});
    bench.run(16);
    ASSERT_EQ(bench.dwells.size(), 1u) << hz;
    EXPECT_EQ(bench.dwells[0].ended_by, EndedBy::drive_stopped) << hz;
    EXPECT_EQ(bench.pipeline.state(), State::idle) << hz;
    bench.set_drive({hz, kChangedAmplitude});
    bench.run(40, [&] { return bench.pipeline.state() == State::measuring; });
    bench.run(bench.now_s() + 2);
    bench.finish();
    ASSERT_EQ(bench.dwells.size(), 2u) << hz;
    EXPECT_NEAR(bench.dwells[1].frequency_hz.value, hz, 5 * bench.dwells[1].frequency_hz.u);
  }
}

std::string name_of(const testing::TestParamInfo<DriveChange>& info) {
  const auto hundredths = [](double hz) { return std::to_string(std::lround(100 * hz)); };
  const DriveChange& change = info.param;
  return "From" + hundredths(change.before_hz) + "To" + hundredths(change.after_hz) + "Nominal" +
         hundredths(change.nominal_hz) + "At" + std::to_string(std::lround(change.rate_hz)) + "Hz";
}

INSTANTIATE_TEST_SUITE_P(Upwards, ChangeOfDrive,
                         testing::Values(DriveChange{4, 5, 4}, DriveChange{4, 6, 4}, DriveChange{4, 7.9, 4},
                                         DriveChange{3.1, 6.2, 3.1}, DriveChange{3.1, 6.2, 5},
                                         DriveChange{3.1, 7.7, 3.1}, DriveChange{4, 6, 4, 60, 0.01}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Downwards, ChangeOfDrive,
                         testing::Values(DriveChange{5, 4, 4}, DriveChange{6, 4, 4}, DriveChange{7.9, 4, 4},
                                         DriveChange{6.2, 3.1, 3.1}, DriveChange{6.2, 3.1, 6.2},
                                         DriveChange{7.7, 3.1, 3.1}, DriveChange{7.7, 3.1, 7.7},
                                         DriveChange{6, 4, 4, 60, 0.01}),
                         name_of);

}  // namespace
}  // namespace dwell
