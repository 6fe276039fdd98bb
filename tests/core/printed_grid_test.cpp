#include "core/intake/printed_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>

#include "core/intake/rounding_step.hpp"

namespace dwell {
namespace {

double printed(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

// A motion of amplitude 1 that the device rounds to `step`, 0: not at all, and that is passed on as `again` has it.
struct Device {
  double step = 0.0, noise = 0.0, per_period = 37.7, glitches = 0.0;
  std::function<double(double)> again = [](double value) { return value; };
};

template <class Finder>
Finder heard(const Device& device, std::uint64_t seed, int readings) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> uniform;
  Finder finder;
  double before = NAN;
  for (int i = 0; i < readings; ++i) {
    double value = 0.013 + std::sin(2 * M_PI * i / device.per_period + 0.3) + device.noise * gauss(rng);
    if (device.step > 0) value = device.step * std::round(value / device.step);
    if (uniform(rng) < device.glitches) value += 0.37 * device.step;
    value = device.again(value);
    if (const double size = std::abs(value - before); size > 0) finder.add(size);
    before = value;
  }
  return finder;
}

// Missed in 4 of 200: a motion that almost repeats has few different differences, and a wide gap between these.
TEST(PrintedGrid, TheStepBeneathFourToNineDigitsIsFound) {
  int found = 0;
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> uniform;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const int digits = 4 + static_cast<int>(6 * uniform(rng));
    const double coarsest = 0.02, finest = std::max(3e-4, 40 * std::pow(10.0, -digits));
    const Device device{.step = finest * std::pow(coarsest / finest, uniform(rng)),
                        .noise = 5e-3 * uniform(rng),
                        .per_period = 10 + 90 * uniform(rng),
                        .again = [=](double value) { return printed(value, digits); }};
    const double step = heard<PrintedGrid>(device, seed, 600).step();
    EXPECT_LT(step, 1.02 * device.step) << digits << " digits, seed " << seed;
    found += step > 0.98 * device.step;
  }
  EXPECT_GE(found, 196);
}

TEST(PrintedGrid, AConverterBehindAFloat32RegisterHasItsStep) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Device device{
        .step = 2.3 / 4096, .noise = 1e-4, .again = [](double value) { return static_cast<float>(value); }};
    EXPECT_NEAR(heard<RoundingStep>(device, seed, 600).step(), device.step, 1e-3 * device.step);
  }
}

TEST(PrintedGrid, AnExactGridIsFoundExactly) {
  for (std::uint64_t seed = 0; seed < 50; ++seed)
    EXPECT_NEAR(heard<RoundingStep>({.step = 1e-3}, seed, 600).step(), 1e-3, 1e-13);
}

// 200 s of each at 1 kHz, twenty times.
TEST(PrintedGrid, ReadingsOnNoGridHaveNone) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    EXPECT_EQ(heard<PrintedGrid>({.noise = 1e-3}, seed, 200'000).step(), 0.0) << seed;
    EXPECT_EQ(heard<PrintedGrid>({.noise = 10.0}, seed, 200'000).step(), 0.0) << seed;
  }
}

// Few different differences, each with what float32 or six digits leave of it.
TEST(PrintedGrid, AMotionThatRepeatsExactlyHasNone) {
  for (int readings = 5; readings <= 60; ++readings)
    for (int parts = 1; parts <= 4; ++parts) {
      const double per_period = readings + 0.25 * (parts - 1);
      EXPECT_EQ(heard<PrintedGrid>({.per_period = per_period}, 1, 20'000).step(), 0.0) << per_period;
      EXPECT_EQ(heard<PrintedGrid>({.per_period = per_period, .again = [](double v) { return static_cast<float>(v); }},
                                   1, 20'000)
                    .step(),
                0.0)
          << per_period;
      // What is found may be the last of the six digits.
      EXPECT_LT(
          heard<PrintedGrid>({.per_period = per_period, .again = [](double v) { return printed(v, 6); }}, 1, 20'000)
              .step(),
          1e-5)
          << per_period;
    }
}

TEST(PrintedGrid, OneReadingInThirtyOffTheGridHidesNothing) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Device device{
        .step = 3e-3, .noise = 1e-3, .glitches = 1.0 / 30, .again = [](double v) { return printed(v, 7); }};
    EXPECT_NEAR(heard<PrintedGrid>(device, seed, 10'000).step(), device.step, 0.02 * device.step) << seed;
  }
}

TEST(PrintedGrid, AFewLevelsSuffice) {
  // The readings are -1, 0 and 1 steps and noise between them.
  const Device device{.step = 0.73, .noise = 0.5, .again = [](double v) { return printed(v, 8); }};
  EXPECT_NEAR(heard<PrintedGrid>(device, 3, 2000).step(), device.step, 1e-3);
}

TEST(PrintedGrid, AnotherGridIsFollowed) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> gauss;
  PrintedGrid grid;
  double before = 0.0;
  for (int i = 0; i < 60'000; ++i) {
    const double step = i < 30'000 ? 0.01 : 0.1;
    const double value = printed(step * std::round(gauss(rng) / step) * 0.7, 7);
    if (value != before) grid.add(std::abs(value - before));
    before = value;
    if (i == 29'000) {
      EXPECT_NEAR(grid.step(), 0.007, 1e-5);
    }
  }
  EXPECT_NEAR(grid.step(), 0.07, 1e-4);
}

}  // namespace
}  // namespace dwell
