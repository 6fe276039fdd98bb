#include "core/drive/sync_reference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kStart_ns = 3'000'000'000'000;

// Pulses of a drive of f Hz from kStart_ns on, each off by its own jitter.
struct Pulses {
  explicit Pulses(double f, double low_hz, double high_hz, std::uint64_t seed = 1)
      : f_hz(f), reference(low_hz, high_hz), rng(seed) {}
  // The next `count` periods.
  void run(int count) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> chance;
    for (int i = 0; i < count; ++i, ++k) {
      const double t = phase_s + k / f_hz;
      if (chance(rng) >= missing) at(t + jitter_s * normal(rng));
      if (chance(rng) < twice) at(t + 0.25 / f_hz);
    }
  }
  void at(double t_s) { reference.pulse(ns(t_s)); }
  static std::int64_t ns(double t_s) { return kStart_ns + std::llround(t_s * 1e9); }
  [[nodiscard]] std::int64_t now_ns() const { return ns(phase_s + k / f_hz); }

  double f_hz, jitter_s = 0.0, missing = 0.0, twice = 0.0, phase_s = 0.0;
  double k = 0;
  SyncReference reference;
  std::mt19937_64 rng;
};

TEST(SyncReference, ExactPulsesGiveFrequencyAndPhaseExactly) {
  Pulses pulses(4.0123, 3.9, 4.1);
  pulses.run(400);
  const auto line = pulses.reference.over(kStart_ns, pulses.now_ns());
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->omega / kTwoPi, 4.0123, 1e-9);
  EXPECT_LT(line->u / kTwoPi, 1e-9);
  const std::int64_t near = line->nearest_ns(Pulses::ns(50.1));
  EXPECT_LE(std::abs(near - Pulses::ns(std::round(50.1 * 4.0123) / 4.0123)), 2);
}

TEST(SyncReference, TheStatedUncertaintyIsThatOfTheFrequency) {
  for (const int count : {8, 40, 3000}) {
    double squares = 0.0;
    constexpr int kTrials = 300;
    for (int trial = 0; trial < kTrials; ++trial) {
      Pulses pulses(10.0, 9.8, 10.2, static_cast<std::uint64_t>(trial));
      pulses.jitter_s = 5e-4;
      pulses.run(count);
      const auto line = pulses.reference.over(kStart_ns - 1'000'000'000, pulses.now_ns());
      ASSERT_TRUE(line) << count;
      squares += std::pow((line->omega - kTwoPi * 10.0) / line->u, 2) / kTrials;
    }
    // χ² of 300 has a relative spread of 0.08; few pulses are treated with reserve.
    EXPECT_LT(squares, 1.25) << count;
    EXPECT_GT(squares, count < 10 ? 0.4 : 0.75) << count;
  }
}

TEST(SyncReference, PulsesThatWanderAreLessCertainThanTheirScatterSays) {
  Pulses white(10.0, 9.8, 10.2), wandering(10.0, 9.8, 10.2);
  white.jitter_s = wandering.jitter_s = 1e-4;
  white.run(2000);
  for (int i = 0; i < 2000; ++i) {
    wandering.phase_s = 3e-4 * std::sin(i / 60.0);
    wandering.run(1);
  }
  const double u_white = white.reference.over(kStart_ns, white.now_ns())->u;
  const auto line = wandering.reference.over(kStart_ns, wandering.now_ns());
  EXPECT_GT(line->u, 5 * u_white);
  EXPECT_LT(std::abs(line->omega - kTwoPi * 10.0), 3 * line->u);
}

TEST(SyncReference, MissedAndDoublePulsesAreCountedAndDoNoHarm) {
  Pulses pulses(4.0, 3.92, 4.08);
  pulses.jitter_s = 1e-4;
  pulses.missing = 0.1;
  pulses.twice = 0.1;
  pulses.run(2400);
  const auto line = pulses.reference.over(kStart_ns, pulses.now_ns());
  ASSERT_TRUE(line);
  EXPECT_LT(std::abs(line->omega - kTwoPi * 4.0), 4 * line->u);
  EXPECT_LT(line->u / line->omega, 1e-6);
  const SyncReference::Counts& counts = pulses.reference.counts();
  EXPECT_NEAR(static_cast<double>(counts.missed), 240, 50);
  EXPECT_NEAR(static_cast<double>(counts.extra), 240, 50);
  EXPECT_NEAR(static_cast<double>(counts.pulses), 2160, 50);
  EXPECT_LE(std::abs(line->nearest_ns(Pulses::ns(300.0)) - Pulses::ns(300.0)), 20'000) << "on the pulses, not between";
}

TEST(SyncReference, AContactThatBouncesIsOnePulse) {
  Pulses pulses(4.0, 3.92, 4.08);
  pulses.run(20);
  for (int i = 0; i < 50; ++i) {
    pulses.run(1);
    pulses.at((pulses.k - 1) / 4.0 + 0.001);
    pulses.at((pulses.k - 1) / 4.0 + 0.002);
  }
  EXPECT_EQ(pulses.reference.counts().extra, 100u);
  EXPECT_EQ(pulses.reference.counts().missed, 0u);
  EXPECT_NEAR(pulses.reference.omega() / kTwoPi, 4.0, 1e-6);
}

TEST(SyncReference, ATrainThatBeganOnStrayPulsesGivesWay) {
  Pulses pulses(4.0, 3.92, 4.08);
  for (int i = 0; i < 4; ++i) pulses.at(i * 0.25 - 0.9);  // as many as begin one
  pulses.run(100);
  const auto line = pulses.reference.over(kStart_ns - 2'000'000'000, pulses.now_ns());
  ASSERT_TRUE(line);
  EXPECT_LE(std::abs(line->nearest_ns(Pulses::ns(10.0)) - Pulses::ns(10.0)), 2);
}

TEST(SyncReference, AnotherFrequencyIsAnotherTrain) {
  Pulses pulses(4.0, 3.0, 6.0);
  pulses.run(40);
  const double changed_s = pulses.k / 4.0;
  for (int i = 0; i < 60; ++i) pulses.at(changed_s + i / 5.0);
  EXPECT_NEAR(pulses.reference.omega() / kTwoPi, 5.0, 1e-6);
  EXPECT_NEAR(pulses.reference.over(kStart_ns, Pulses::ns(changed_s))->omega / kTwoPi, 4.0, 1e-6);
  EXPECT_NEAR(pulses.reference.over(Pulses::ns(changed_s + 1), Pulses::ns(changed_s + 12))->omega / kTwoPi, 5.0, 1e-6);
}

TEST(SyncReference, IsLostWhenNoPulseComesAndBackWithTheFirstFew) {
  Pulses pulses(4.0, 3.92, 4.08);
  EXPECT_FALSE(pulses.reference.present(kStart_ns));
  pulses.run(3);
  EXPECT_FALSE(pulses.reference.present(pulses.now_ns())) << "three could be anything";
  pulses.run(20);
  EXPECT_TRUE(pulses.reference.present(pulses.now_ns()));
  EXPECT_TRUE(pulses.reference.present(pulses.now_ns() + 1'500'000'000));
  EXPECT_FALSE(pulses.reference.present(pulses.now_ns() + 2'000'000'000));
  pulses.k += 400;
  pulses.run(3);
  EXPECT_FALSE(pulses.reference.present(pulses.now_ns()));
  pulses.run(1);
  EXPECT_TRUE(pulses.reference.present(pulses.now_ns()));
}

TEST(SyncReference, PulsesOfAnotherRateAreNone) {
  for (const double f : {2.0, 8.0, 4.6, 1000.0}) {
    Pulses pulses(f, 3.92, 4.08);
    pulses.run(200);
    EXPECT_FALSE(pulses.reference.present(pulses.now_ns())) << f;
    EXPECT_FALSE(pulses.reference.over(kStart_ns, pulses.now_ns())) << f;
  }
}

TEST(SyncReference, AnyTrainHoweverLongIsKeptByItsLine) {
  Pulses pulses(1000.0, 980.0, 1020.0);
  pulses.jitter_s = 1e-5;
  pulses.run(600'000);
  const std::int64_t begin_ns = pulses.now_ns() - 590'000'000'000;
  const auto all = pulses.reference.over(begin_ns, pulses.now_ns());
  ASSERT_TRUE(all);
  EXPECT_GT(all->span_s, 500.0);
  EXPECT_LT(std::abs(all->omega - kTwoPi * 1000.0), 4 * all->u);
  const auto latest = pulses.reference.over(pulses.now_ns() - 20'000'000, pulses.now_ns());
  ASSERT_TRUE(latest);
  EXPECT_GT(latest->span_s, 0.012) << "the newest are kept finely";
}

TEST(SyncReference, WhateverComesNothingOverflows) {
  std::mt19937_64 rng(7);
  std::exponential_distribution<double> wait(8.0);
  Pulses pulses(4.0, 3.0, 6.0);
  double t = 0.0;
  for (int i = 0; i < 200'000; ++i) {
    pulses.at(t);
    t += i % 7 == 0 ? 0.0 : wait(rng);
    if (i % 1000 != 0) continue;
    const auto line = pulses.reference.over(kStart_ns, Pulses::ns(t));
    if (line) {
      EXPECT_TRUE(std::isfinite(line->omega) && line->omega > 0 && std::isfinite(line->u));
    }
  }
}

}  // namespace
}  // namespace dwell
