#include "core/drive/step_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dwell {
namespace {

constexpr double kTolerance = 0.005, kAmplitude = 0.002, kDrive = 2 * M_PI * 5.0, kReadings_hz = 100.0;

// A table of amplitude 2 mm at 5 Hz, noise as given; quarters until the watch says that the drive is another, from the
// step on; -1: it says so before, quarters + 1: never.
int quarters_until_seen(double noise, double amplitude_step, double frequency_step, int steady, int quarters,
                        std::uint64_t seed = 1, double spike = 0.0) {
  StepWatch watch(kTolerance);
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  StepWatch::Reference reference{};
  reference.X[0] = kAmplitude;
  reference.harmonics = 1;
  reference.omega = kDrive;
  reference.sigma = noise * kAmplitude;
  watch.refer(reference);
  int next = 1;
  const double step_s = steady * 0.05;
  for (int i = 0;; ++i) {
    const double t_s = i / kReadings_hz, since_s = std::max(0.0, t_s - step_s);
    for (; t_s >= 0.05 * next; ++next) {
      const bool seen = watch.close();
      if (seen) return next <= steady ? -1 : next - steady;
      if (next - steady > quarters) return quarters + 1;
    }
    const double amplitude = kAmplitude * (since_s > 0 ? 1 + amplitude_step : 1);
    double value = amplitude * std::sin(kDrive * (t_s + frequency_step * since_s));
    if (i == static_cast<int>(step_s * kReadings_hz) + 3) value += spike;
    watch.add(std::llround(t_s * 1e9), value + reference.sigma * normal(rng));
  }
}

TEST(StepWatch, SeesAStepWellAboveTheNoiseWithinTwoPeriods) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    EXPECT_LE(quarters_until_seen(1e-3, 0.016, 0, 40, 20, seed), 8) << seed;
    EXPECT_LE(quarters_until_seen(1e-3, 0, -0.016, 40, 20, seed), 8) << seed;
  }
}

TEST(StepWatch, SeesASmallStepOnceItHasReachedNineStandardDeviations) {
  // 1.6 % in noise of 5 %: √(2/N) 5 % is a ninth of that after N = 1580 readings, 316 quarters.
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    EXPECT_LE(quarters_until_seen(0.05, 0.016, 0, 40, 400, seed), 316) << seed;
}

TEST(StepWatch, SaysNothingOfASteadyDrive) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    EXPECT_EQ(quarters_until_seen(0.05, 0, 0, 40, 5000, seed), 5001) << seed;
}

TEST(StepWatch, OneReadingIsNoStepHoweverWrongItIs) {
  for (const double spike : {0.01, -0.1, 1e3}) EXPECT_EQ(quarters_until_seen(1e-3, 0, 0, 40, 100, 1, spike), 101);
}

TEST(StepWatch, ReadingsThatAreKnownToBeLateAreNoOtherFrequency) {
  for (const double known_s : {0.0, 0.01}) {
    StepWatch watch(kTolerance);
    StepWatch::Reference reference{};
    reference.X[0] = kAmplitude;
    reference.harmonics = 1;
    reference.omega = kDrive;
    reference.sigma = 1e-3 * kAmplitude;
    watch.refer(reference);
    bool seen = false;
    for (int i = 0, next = 1; i < 400; ++i) {
      const double t_s = i / kReadings_hz;
      for (; t_s >= 0.05 * next; ++next) seen = watch.close() || seen;
      const bool late = i >= 300;  // stamped 10 ms after it was taken
      watch.add(std::llround(t_s * 1e9), kAmplitude * std::sin(kDrive * (t_s - (late ? 0.01 : 0.0))),
                late ? known_s : 0);
    }
    EXPECT_EQ(seen, known_s == 0) << known_s;
  }
}

TEST(StepWatch, WhatWasSeenBeforeIsBroughtToABetterReference) {
  // The same drive told of with another instant and a slightly other frequency, over and over: no step.
  StepWatch watch(kTolerance);
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  for (int i = 0, next = 1; i < 20000; ++i) {
    const double t_s = i / kReadings_hz;
    for (; t_s >= 0.05 * next; ++next) {
      EXPECT_FALSE(watch.close()) << t_s;
      if (next % 16 != 1) continue;
      StepWatch::Reference reference{};
      reference.t_ref_ns = std::llround(0.5e9 * t_s);
      reference.omega = kDrive * (1 + 1e-6 * normal(rng));
      reference.X[0] = std::polar(kAmplitude * (1 + 1e-4 * normal(rng)), std::remainder(kDrive * 0.5 * t_s, 2 * M_PI));
      reference.harmonics = 1;
      reference.sigma = 1e-2 * kAmplitude;
      watch.refer(reference);
    }
    watch.add(std::llround(t_s * 1e9), kAmplitude * (std::sin(kDrive * t_s) + 1e-2 * normal(rng)));
  }
}

}  // namespace
}  // namespace dwell
