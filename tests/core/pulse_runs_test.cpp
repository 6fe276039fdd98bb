#include "core/drive/pulse_runs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

// Pulses of a train of `f_hz` that begins at begin_ns and whose first guess is off by a thousandth.
struct KeptTrain {
  PulseTrain train;
  double f_hz;

  [[nodiscard]] std::int64_t at(std::int64_t k) const {
    return train.begin_ns + std::llround(1e9 * static_cast<double>(k) / f_hz);
  }
  void keep(PulseRuns& runs, std::int64_t from, std::int64_t to) const {
    for (std::int64_t k = from; k < to; ++k) runs.keep(train, at(k), k);
  }
};
KeptTrain train_of(double f_hz, std::uint64_t number, std::int64_t begin_ns) {
  return {{number, begin_ns, 1.001 / f_hz}, f_hz};
}

TEST(PulseRuns, TheLineIsThatOfThePulsesWhateverTheFirstGuess) {
  PulseRuns runs;
  const KeptTrain train = train_of(4.0, 1, 7'000'000'000);
  train.keep(runs, 0, 300);
  const auto line = runs.over(0, INT64_MAX);
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->omega / kTwoPi, 4.0, 1e-9);
  EXPECT_EQ(line->nearest_ns(train.at(100) + 30'000'000), train.at(100));
  EXPECT_NEAR(line->span_s, 299 / 4.0, 1e-9);
}

TEST(PulseRuns, FewerThanTheFewestHaveNoLine) {
  PulseRuns runs;
  const KeptTrain train = train_of(4.0, 1, 0);
  train.keep(runs, 0, PulseRuns::kFewest - 1);
  EXPECT_FALSE(runs.over(0, INT64_MAX));
  train.keep(runs, PulseRuns::kFewest - 1, PulseRuns::kFewest);
  EXPECT_TRUE(runs.over(0, INT64_MAX));
}

TEST(PulseRuns, OfTwoTrainsInAStretchTheOneWithMorePulsesSpeaks) {
  PulseRuns runs;
  const KeptTrain first = train_of(4.0, 1, 0), second = train_of(5.0, 2, first.at(12) + 400'000'000);
  first.keep(runs, 0, 12);
  second.keep(runs, 0, 8);
  EXPECT_NEAR(runs.over(0, INT64_MAX)->omega / kTwoPi, 4.0, 1e-9);
  second.keep(runs, 8, 20);
  EXPECT_NEAR(runs.over(0, INT64_MAX)->omega / kTwoPi, 5.0, 1e-9);
  EXPECT_NEAR(runs.over(0, first.at(12))->omega / kTwoPi, 4.0, 1e-9) << "only what lies in the stretch counts";
}

TEST(PulseRuns, JoinedRunsKeepTheLineAndItsUncertainty) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  const KeptTrain train = train_of(10.0, 1, 0);
  constexpr int kPulses = 5000;
  constexpr double kJitter_s = 1e-4;
  PulseRuns runs;
  for (std::int64_t k = 0; k < kPulses; ++k)
    runs.keep(train.train, train.at(k) + std::llround(1e9 * kJitter_s * normal(rng)), k);
  const auto line = runs.over(INT64_MIN, INT64_MAX);
  ASSERT_TRUE(line);
  // Of n equidistant points with scatter s a line's slope is uncertain by s √(12/n³): relative to T that of ω.
  const double expected = line->omega * kJitter_s * 10.0 * std::sqrt(12.0 / std::pow(kPulses, 3));
  EXPECT_NEAR(line->u, expected, 0.25 * expected) << "some forty means of runs tell their scatter to a tenth";
  EXPECT_LT(std::abs(line->omega - kTwoPi * 10.0), 4 * line->u);
}

}  // namespace
}  // namespace dwell
