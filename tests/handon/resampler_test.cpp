// Even instants from irregular readings: how far off they are, and whether the stated error says so.
#include "daemon/handon/resampler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "daemon/handon/uff_plan.hpp"

namespace dwell::handon {
namespace {

constexpr std::int64_t kInterval_ns = 1'000'000;

struct Outcome {
  double rms = 0.0, largest = 0.0;
  std::size_t count = 0;
  Resampler::Check check;
};

struct Given {
  std::function<double(double)> signal;  // of the time in intervals
  double noise = 0.0;                    // standard deviation
  double missing = 0.0;                  // part of the readings; never two in a row
};

// 3000 readings, a fifth of an interval off an even grid at most, read at a step of 0.8 intervals.
Outcome resample(const Given& given, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> off(-0.2, 0.2), part(0.0, 1.0);
  std::normal_distribution<double> normal;
  Resampler resampler(static_cast<double>(kInterval_ns), 800'000);
  resampler.begin(16 * kInterval_ns + kInterval_ns / 2);
  SharedInstants shared;
  Outcome outcome;
  bool left_out = false;
  for (int i = 0; i < 3000; ++i) {
    const auto t_ns = static_cast<std::int64_t>((i + off(rng)) * static_cast<double>(kInterval_ns));
    left_out = !left_out && i > 20 && part(rng) < given.missing;
    const double x =
        given.signal(static_cast<double>(t_ns) / static_cast<double>(kInterval_ns)) + given.noise * normal(rng);
    if (left_out) continue;
    resampler.push(shared, t_ns, x, [&](std::int64_t at_ns, double y) {
      const double error = y - given.signal(static_cast<double>(at_ns) / static_cast<double>(kInterval_ns));
      outcome.rms += error * error;
      outcome.largest = std::max(outcome.largest, std::fabs(error));
      ++outcome.count;
    });
  }
  outcome.rms = std::sqrt(outcome.rms / static_cast<double>(outcome.count));
  outcome.check = resampler.check();
  return outcome;
}

std::function<double(double)> sine(double frequency) {
  return [frequency](double t) { return 100.0 + std::sin(2.0 * std::numbers::pi * frequency * t + 0.3); };
}

TEST(Resampling, FollowsSinesUpToAQuarterOfTheRateWithin1e5OfTheirAmplitude) {
  for (const double frequency : {0.001, 0.02, 0.1, 0.25}) {
    EXPECT_LT(resample({sine(frequency)}, 1).largest, 2e-5) << frequency;
    EXPECT_LT(resample({sine(frequency), 0.0, 0.03}, 2).rms, 1e-5) << frequency;
  }
}

TEST(Resampling, StatesAtLeastTheErrorThatItMakes) {
  for (const double frequency : {0.02, 0.1, 0.25, 0.33, 0.4})  // the last beyond the band
    for (const double noise : {0.0, 1e-4, 1e-2}) {
      const Outcome outcome = resample({sine(frequency), noise}, 3);
      EXPECT_GT(outcome.check.rms(), 0.9 * outcome.rms) << frequency << " " << noise;
      EXPECT_GT(outcome.check.count, 150U);
      // With noise alone the statement is at most three times too large.
      if (noise > 0.0 && frequency < 0.3) {
        EXPECT_LT(outcome.check.rms(), 3.0 * outcome.rms) << frequency << " " << noise;
      }
    }
}

TEST(Resampling, HandsOutEachEvenInstantOnceAndInOrder) {
  Resampler resampler(1000.0, 700);
  resampler.begin(16'100);
  SharedInstants shared;
  std::int64_t expected_ns = 16'100;
  for (std::int64_t i = 0; i < 1000; ++i)
    resampler.push(shared, i * 1000, 1.0, [&](std::int64_t at_ns, double y) {
      EXPECT_EQ(at_ns, expected_ns);
      EXPECT_NEAR(y, 1.0, 1e-9);
      expected_ns += 700;
    });
  EXPECT_GE(expected_ns, 984'000);
}

TEST(Resampling, SharedInstantsChangeNoBit) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> off(-0.2, 0.2), reading(-1.0, 1.0);
  std::vector<Resampler> together(3, Resampler(1000.0, 800)), alone(3, Resampler(1000.0, 800));
  SharedInstants shared;
  for (std::size_t c = 0; c < 3; ++c) {
    together[c].begin(16'500);
    alone[c].begin(16'500);
  }
  for (int i = 0; i < 200; ++i) {
    const auto t_ns = static_cast<std::int64_t>((i + off(rng)) * 1000.0);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int64_t own_ns = t_ns + (c == 2 ? 40 : 0);  // the third is read a little later
      const double x = reading(rng);
      std::vector<double> a, b;
      SharedInstants fresh;
      together[c].push(shared, own_ns, x, [&](std::int64_t, double y) { a.push_back(y); });
      alone[c].push(fresh, own_ns, x, [&](std::int64_t, double y) { b.push_back(y); });
      EXPECT_EQ(a, b);
    }
  }
  EXPECT_EQ(together[1].check().rms(), alone[1].check().rms());
  EXPECT_GT(together[1].check().count, 0U);
}

TEST(EvenSteps, AreExactInSixDigits) {
  EXPECT_EQ(even_step_ns(1e6), 1'000'000);
  EXPECT_EQ(even_step_ns(999'000.0), 1'000'000) << "2 % longer is near enough";
  EXPECT_EQ(even_step_ns(970'000.0), 800'000);
  EXPECT_EQ(even_step_ns(3.333e6), 2'500'000);
  EXPECT_EQ(even_step_ns(1e10), 10'000'000'000);
  for (const std::int64_t t_ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{123'456'789}, std::int64_t{86'400'123'456'789}})
    for (const std::int64_t step_ns : {100'000, 2'500'000, 8'000'000}) {
      const std::int64_t start_ns = even_start_ns(t_ns, step_ns);
      EXPECT_GE(start_ns, t_ns);
      EXPECT_EQ(start_ns % step_ns, 0);
      EXPECT_LE(start_ns - t_ns, std::max<std::int64_t>(10 * step_ns, t_ns / 10'000)) << t_ns << " " << step_ns;
      char text[32];
      std::snprintf(text, sizeof text, "%13.5E", static_cast<double>(start_ns) * 1e-9);
      EXPECT_EQ(std::llround(std::atof(text) * 1e9), start_ns) << text;
    }
}

}  // namespace
}  // namespace dwell::handon
