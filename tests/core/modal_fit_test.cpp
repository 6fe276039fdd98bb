#include "core/transient/modal_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

constexpr double kModalOmega = 2 * M_PI * 5.0, kModalRate_hz = 200.0;

// 3 + 2 sin ωu + decaying modes + noise, as readings of channel 0.
void show(ModalFit& fit, const std::vector<Complex>& poles, const std::vector<Complex>& amplitudes, double seconds,
          double noise, std::uint64_t seed = 1) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < seconds * kModalRate_hz; ++i) {
    const std::int64_t t_ns = 5'000'000LL * i;
    const double u = 1e-9 * static_cast<double>(t_ns);
    double value = 3 + 2 * std::sin(kModalOmega * u) + noise * normal(rng);
    for (std::size_t m = 0; m < poles.size(); ++m) value += (amplitudes[m] * std::exp(poles[m] * u)).real();
    fit.add(0, t_ns, value);
  }
}

TEST(ModalFit, TellsTheSteadyMotionFromAModeNearItExactlyWhereThereIsNoNoise) {
  const std::vector<Complex> poles{{-0.5, 33.0}, {-2.0, 60.0}};
  ModalFit fit(1, 2, 4);
  fit.restart(kModalOmega, 0.0, 0, poles);
  show(fit, poles, {{0.7, 0.3}, {-0.2, 0.5}}, 2.0, 0.0);
  ASSERT_TRUE(fit.solve(0, 1e3, 1e3));
  EXPECT_LT(std::abs(fit.phasor(0, 1) - Complex{2.0, 0.0}), 1e-6);
  EXPECT_LT(std::abs(fit.phasor(0, 2)), 1e-6);
  EXPECT_NEAR(fit.disturbance(0, 1'000'000'000),
              (Complex{0.7, 0.3} * std::exp(poles[0]) + Complex{-0.2, 0.5} * std::exp(poles[1])).real(), 1e-6);
}

// A pole that it was told as `told`, after so many steps.
Complex refined(ModalFit& fit, Complex told, Complex truth, Complex amplitude, int steps) {
  std::vector<Complex> poles{told};
  for (int step = 0; step < steps; ++step) {
    fit.restart(kModalOmega, 0.0, 0, poles);
    show(fit, {truth}, {amplitude}, 4.0, 1e-3);
    EXPECT_TRUE(fit.solve(0, 10, 10));
    fit.step_poles(0.05, 0.0);
    const auto moved = fit.moved_poles();
    poles.assign(moved.begin(), moved.end());
  }
  return poles[0];
}

TEST(ModalFit, FindsAPoleThatItWasToldWrong) {
  const Complex truth{-0.5, 33.0};
  ModalFit fit(1, 1, 2);
  const Complex found = refined(fit, {-0.6, 33.6}, truth, {0.7, 0.3}, 12);
  EXPECT_LT(std::abs(found - truth), 4 * fit.u_pole(0));
  EXPECT_LT(fit.u_pole(0), 1e-3 * std::abs(truth));
}

TEST(ModalFit, FindsASteadyLineThatItWasToldALittleWrong) {
  const Complex truth{0.0, 45.0}, told = 1.0005 * truth, amplitude{0.1, 0.05};
  ModalFit fit(1, 1, 2);
  static_cast<void>(refined(fit, told, truth, amplitude, 1));
  EXPECT_GT(fit.last_step(), 0.1);
  const Complex found = refined(fit, told, truth, amplitude, 6);
  EXPECT_LT(std::abs(found - truth), 4 * fit.u_pole(0));
  EXPECT_LT(fit.last_step(), 0.1);
  EXPECT_LT(fit.u_pole(0), 1e-4 * std::abs(truth));
}

TEST(ModalFit, WhatMayBeLeftCoversWhatIsLeftInNineteenOfTwentyNoises) {
  const Complex pole{-0.8, 29.0};
  int covered = 0, false_alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    ModalFit fit(1, 1, 2);
    const std::vector<Complex> poles{pole};
    fit.restart(kModalOmega, 0.0, 0, poles);
    show(fit, poles, {{0.05, 0.0}}, 1.0, 0.02, seed);
    ASSERT_TRUE(fit.solve(0, 1, 1));
    const auto left = fit.left(0, 1'000'000'000);
    covered += left.envelope + 2 * left.u > 0.05 * std::exp(-0.8);
    // No noise, no transient: what is left is told to be no more than the noise allows to say.
    fit.restart(kModalOmega, 0.0, 0, poles);
    show(fit, {}, {}, 1.0, 0.02, seed);
    ASSERT_TRUE(fit.solve(0, 1, 1));
    false_alarms += fit.left(0, 1'000'000'000).envelope > 0;
  }
  EXPECT_GE(covered, 190);
  EXPECT_LE(false_alarms, 20);
}

TEST(ModalFit, BeforeASlowModeCanBeToldFromTheSteadyMotionItsUncertaintyIsTheWholeRange) {
  const std::vector<Complex> poles{{-0.05, kModalOmega * 1.001}};
  ModalFit fit(1, 1, 2);
  fit.restart(kModalOmega, 0.0, 0, poles);
  show(fit, {}, {}, 0.6, 0.1);
  ASSERT_TRUE(fit.solve(0, 2.0, 2.0));
  EXPECT_GT(fit.left(0, 600'000'000).u, 0.5);
}

// Driven at a natural frequency, what is not known of the pole and of the drive's frequency is nearly all that is not
// known of the mode: the uncertainty without it is less than half of the error seen.
TEST(ModalFit, WhatIsNotKnownOfPoleAndFrequencyIsInWhatMayBeLeft) {
  const Complex truth{-0.15, 1.001 * kModalOmega}, amplitude{-1.5, 0.5};
  const std::int64_t t_ns = 10'000'000'000;
  const double given = (amplitude * std::exp(10.0 * truth)).real();
  double with = 0.0, without = 0.0;
  int fits = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    ModalFit fit(1, 1, 1);
    std::vector<Complex> poles{{-0.16, 1.0012 * kModalOmega}};
    double omega = kModalOmega * (1 + 1e-4);
    for (int step = 0; step < 12; ++step) {
      fit.restart(omega, 0.0, 0, poles);
      show(fit, {truth}, {amplitude}, 10.0, 0.01, seed);
      ASSERT_TRUE(fit.solve(0, 10, 10));
      if (step == 11) break;
      fit.step_poles(0.05, 0.005);
      const auto moved = fit.moved_poles();
      poles.assign(moved.begin(), moved.end());
      omega = fit.moved_omega();
    }
    const double error = fit.disturbance(0, t_ns) - given, narrow = fit.left(0, t_ns).u;
    fit.propagate_poles(false);
    const double wide = fit.left(0, t_ns).u;
    EXPECT_GE(wide, narrow);
    without += error * error / (narrow * narrow);
    with += error * error / (wide * wide);
    ++fits;
  }
  EXPECT_GT(without / fits, 4.0);
  // The stated one is the largest of half a cycle, the error is that of one instant of it.
  EXPECT_LT(with / fits, 1.5);
  EXPECT_GT(with / fits, 0.1);
}

TEST(ModalFit, KnowsNoMoreOfTheAmplitudesWhereThePolesAreOpenAndNoLessWhereThereIsNoMode) {
  const std::vector<Complex> poles{{-0.5, 33.0}};
  ModalFit fit(1, 1, 1);
  fit.restart(kModalOmega, 0.0, 0, poles);
  show(fit, {}, {}, 2.0, 0.0);
  ASSERT_TRUE(fit.solve(0, 1, 1));
  const double before = fit.left(0, 0).u;
  fit.propagate_poles(true);
  EXPECT_NEAR(fit.left(0, 0).u, before, 1e-3 * before);  // of a mode that is not there no pole matters
}

TEST(ModalFit, ASteadyLineIsTakenOutButIsNoTransient) {
  const std::vector<Complex> poles{{0.0, 2 * M_PI * 50.02}};
  ModalFit fit(1, 1, 2);
  fit.restart(kModalOmega, 0.0, 0, poles);
  show(fit, poles, {{0.3, 0.4}}, 3.0, 1e-3);
  ASSERT_TRUE(fit.solve(0, 0.0, 1.0));
  EXPECT_EQ(fit.left(0, 0).envelope, 0.0);
  EXPECT_NEAR(fit.disturbance(0, 0), 0.3, 1e-3);
}

// Two channels that share a pole; in the first another beside it may ring.
ModalFit of_two(double ring, std::uint64_t seed) {
  const Complex pole{-1.0, 33.0}, beside{-0.8, 33.7};
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  ModalFit fit(2, 1, 1);
  std::vector<Complex> poles{pole};
  for (int step = 0; step < 6; ++step) {
    rng.seed(seed);
    fit.restart(kModalOmega, 0.0, 0, poles);
    for (int i = 0; i < 800; ++i)
      for (int c = 0; c < 2; ++c) {
        const double u = i / kModalRate_hz;
        double value = 2 * std::sin(kModalOmega * u + c) + (Complex{0.5, 0.2 * c} * std::exp(pole * u)).real();
        if (c == 0) value += ring * std::exp(beside * u).real();
        fit.add(c, static_cast<std::int64_t>(1e9 * u), value + 1e-2 * normal(rng));
      }
    for (int c = 0; c < 2; ++c) EXPECT_TRUE(fit.solve(c, 5, 5));
    fit.step_poles(0.05, 0.0);
    const auto moved = fit.moved_poles();
    poles.assign(moved.begin(), moved.end());
  }
  return fit;
}

TEST(ModalFit, ChannelsDisagreeAboutAPoleWhereOneOfThemRingsBesideIt) {
  int beyond = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const double sound = of_two(0.0, seed).disagreement(0);
    beyond += sound > 2 * std::log(20.0);  // χ² of two: once in twenty, or less
    if (seed <= 20) {
      EXPECT_GT(of_two(0.1, seed).disagreement(0), 2 * std::log(1e4)) << seed;
    }
  }
  EXPECT_LE(beyond, 6);
}

TEST(ModalFit, IsCertainOfAModeThatIsThereAndOfNoneInNoise) {
  const std::vector<Complex> poles{{-0.5, 33.0}};
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    ModalFit fit(1, 1, 1);
    fit.restart(kModalOmega, 0.0, 0, poles);
    show(fit, {}, {}, 4.0, 0.02, seed);
    ASSERT_TRUE(fit.solve(0, 1, 1));
    EXPECT_FALSE(fit.certain(0)) << seed;
  }
  ModalFit fit(1, 1, 1);
  fit.restart(kModalOmega, 0.0, 0, poles);
  show(fit, poles, {{0.02, 0.0}}, 4.0, 0.02);
  ASSERT_TRUE(fit.solve(0, 1, 1));
  EXPECT_TRUE(fit.certain(0));
}

}  // namespace
}  // namespace dwell
