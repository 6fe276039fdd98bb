// The refined frequency of the drive, and what its sums are worth.
#include "core/drive/refine.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/fit/blocks.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kHz = 4.0, kOmega = 2 * M_PI * kHz, kNoise = 1e-3;
constexpr std::int64_t kStep_ns = 5'000'000;
constexpr int kReadingsPerQuarter = 12;

// Blocks at `omega` of a table that moves at kOmega with unit amplitude, so many quarters of a period.
void fill(Blocks& blocks, int quarters, double omega, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, kNoise);
  const double phase = std::uniform_real_distribution<double>(0, 2 * M_PI)(random);
  for (int q = 0; q < quarters; ++q) {
    const std::int64_t begin_ns = q * kReadingsPerQuarter * kStep_ns;
    blocks.open(begin_ns, begin_ns + kReadingsPerQuarter * kStep_ns, omega);
    for (int i = 0; i < kReadingsPerQuarter; ++i) {
      const std::int64_t t_ns = begin_ns + i * kStep_ns;
      blocks.add(0, t_ns, std::sin(kOmega * 1e-9 * static_cast<double>(t_ns) + phase) + noise(random));
    }
    blocks.close();
  }
}

// Turning the sums too far once hid the noise in data of few periods. The phasor's standard uncertainty was then
// ten thousand times too small.
TEST(Refine, TheSumsThatItTurnsKeepTheNoiseInDataOfAnyLength) {
  const Rig rig = rig_of({Boundary::clamped, {}, {24000}, {31.2}}, kHz);
  const int channels = static_cast<int>(rig.channels.size()), H = rig.excitation.harmonics;
  for (const int quarters : {6, 9, 15, 40, 200})
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const double off =
          (static_cast<double>(seed) - 19.5) / 20 * 4e-3 / (1e-9 * kStep_ns * kReadingsPerQuarter * quarters / 2);
      Blocks blocks(channels, H);
      fill(blocks, quarters, kOmega + off, seed);
      const std::int64_t middle_ns = quarters * kReadingsPerQuarter * kStep_ns / 2;
      Totals sums(channels, H), turned(channels, H);
      Refined refined{.omega = kOmega + off, .sums_valid = false};
      for (int i = 0; i < 5 && !refined.sums_valid; ++i) {
        blocks.sum(0, blocks.count(), refined.omega, middle_ns, sums);
        refined = refine(rig, sums, 0, turned);
      }
      EXPECT_TRUE(refined.sums_valid) << quarters << " quarters, seed " << seed;
      Blocks anew(channels, H);
      fill(anew, quarters, refined.omega, seed);
      anew.sum(0, anew.count(), refined.omega, middle_ns, sums);
      const double exact = fit_harmonics(sums, 0, H, 0.0).sigma2;
      // The noise is 2e-6 of Σs². Turning may cost 2e-8 of it, a hundredth; so may each block, taken so far off.
      EXPECT_NEAR(fit_harmonics(turned, 0, H, 0.0).sigma2 / exact, 1.0, 0.05) << quarters << " quarters, seed " << seed;
    }
}

}  // namespace
}  // namespace dwell
