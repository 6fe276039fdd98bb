#include "core/verify/timing_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/verify/verification_stretch.hpp"

namespace dwell {
namespace {

constexpr double kShaken_rad_s = kTwoPi * 4.0, kStroke_m = 5e-3, kRead_hz = 200;

// Readings of a steady motion. sigma: of the values; scatter_s: of the instants.
ChannelReadings steady_motion(double sigma, double scatter_s, int count, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  ChannelReadings out;
  for (int i = 0; i < count; ++i) {
    const double t_s = i / kRead_hz, read_s = t_s + scatter_s * normal(rng);
    out.t_ns.push_back(to_ns(t_s));
    out.value.push_back(kStroke_m * std::cos(kShaken_rad_s * read_s) + 2e-4 * std::sin(3 * kShaken_rad_s * read_s) +
                        sigma * normal(rng));
  }
  return out;
}

TEST(TimingNoise, IsToldFromNoiseOfTheValues) {
  const double as_large_s = std::sqrt(2.0) * 1e-5 / (kShaken_rad_s * kStroke_m);  // makes noise of 10 µm
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TimingNoise of_values = timing_noise_of(steady_motion(1e-5, 0.0, 4000, seed), kShaken_rad_s, 3);
    const TimingNoise of_instants = timing_noise_of(steady_motion(1e-8, as_large_s, 4000, seed), kShaken_rad_s, 3);
    const TimingNoise of_both = timing_noise_of(steady_motion(1e-5, as_large_s, 4000, seed), kShaken_rad_s, 3);
    EXPECT_LT(of_values.part, 4 * of_values.u);
    EXPECT_GT(of_instants.part, 1 - 4 * of_instants.u);
    EXPECT_NEAR(of_both.part, 0.5, 4 * of_both.u);
  }
}

TEST(TimingNoise, StatesHowWellItIsKnown) {
  const double as_large_s = std::sqrt(2.0) * 1e-5 / (kShaken_rad_s * kStroke_m);
  double squares = 0.0;
  constexpr int kTimes = 400;
  for (std::uint64_t seed = 1; seed <= kTimes; ++seed) {
    const TimingNoise seen = timing_noise_of(steady_motion(1e-5, as_large_s, 1000, seed), kShaken_rad_s, 3);
    squares += std::pow((seen.part - 0.5) / seen.u, 2);
  }
  EXPECT_NEAR(std::sqrt(squares / kTimes), 1.0, 0.15);  // four standard deviations of such a figure
}

TEST(TimingNoise, IsNotKnownFromFewReadings) {
  const TimingNoise seen = timing_noise_of(steady_motion(1e-5, 1e-4, 55, 1), kShaken_rad_s, 3);
  EXPECT_EQ(seen.part, 0.0);
  EXPECT_EQ(seen.u, 0.0);
  EXPECT_EQ(seen.mean_square_velocity(steady_motion(1e-5, 0.0, 100, 1)), 1.0);
}

TEST(TimingNoise, GrowsWithVelocity) {
  const TimingNoise of_instants{
      .part = 1.0, .u = 0.0, .steady_velocity2 = 0.5 * std::pow(kShaken_rad_s * kStroke_m, 2)};
  ChannelReadings twice = steady_motion(0.0, 0.0, 2000, 1);
  for (double& value : twice.value) value *= 2;
  EXPECT_NEAR(of_instants.mean_square_velocity(twice), 4.0, 0.1);
  const std::vector<double> relative = of_instants.relative_to_steady(twice);
  EXPECT_NEAR(relative[25], 0.0, 0.6);                 // at an end of the stroke, but for the third harmonic
  EXPECT_NEAR(relative[12], 2 * std::sqrt(2.0), 0.4);  // amid
  const TimingNoise of_values{.part = 0.0, .u = 0.1, .steady_velocity2 = of_instants.steady_velocity2};
  EXPECT_EQ(of_values.relative_to_steady(twice), std::vector<double>(2000, 1.0));
}

}  // namespace
}  // namespace dwell
