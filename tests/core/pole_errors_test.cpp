#include "core/transient/pole_errors.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/base/complex.hpp"
#include "tests/core/modal_channel.hpp"

namespace dwell {
namespace {

const ModalChannel::Poles kOpenPole{{-0.5, 33.0}};

struct Propagated {
  Propagated(ModalChannel& channel, bool shows, double omega_information)
      : errors(ModalChannel::kMost), effect(ModalChannel::kMost) {
    const std::array<bool, ModalMotion::kMaxModes> shown{shows};
    EXPECT_TRUE(channel.solve());
    errors.begin(channel.layout());
    EXPECT_TRUE(channel.eliminate());
    errors.add(channel.layout(), channel.motion(), channel.solution, channel.linear, shown, effect);
    EXPECT_TRUE(errors.solve(channel.layout(), channel.motion(), 4.0, omega_information));
    errors.propagate(channel.layout(), channel.solution, effect);
  }
  PoleErrors errors;
  PoleErrors::Effect effect;
};

TEST(PoleErrors, OfAModeThatDoesNotShowThePriorIsAllThatIsKnownAndHarmsNothing) {
  ModalChannel channel({{}, {}, 0.01, 4.0}, kOpenPole);
  const Propagated of(channel, false, 1e24);
  // |Re λ| is 0.5/s and 1/T 0.25/s: the wider holds, relative to |λ|.
  const double width = 0.5 / std::abs(kOpenPole[0]);
  EXPECT_NEAR(of.errors.covariance()(0, 0), width * width, 1e-9 * width * width);
  EXPECT_NEAR(of.errors.covariance()(1, 1), width * width, 1e-9 * width * width);
  const Eigen::Matrix2d given = channel.solution.amplitude_covariance(0);
  const Eigen::Matrix2d whole = of.effect.whole.topLeftCorner<2, 2>();
  EXPECT_LT((whole - given).norm(), 1e-6 * given.norm());
}

TEST(PoleErrors, WhatThePoleLeavesOpenWidensTheAmplitude) {
  ModalChannel channel({kOpenPole, {{0.7, 0.3}}, 0.01, 4.0}, kOpenPole);
  const Propagated of(channel, true, 1e24);
  const Eigen::Matrix2d whole = of.effect.whole.topLeftCorner<2, 2>();
  EXPECT_GT(whole.trace(), 1.5 * channel.solution.amplitude_covariance(0).trace());
}

// Amplitudes fitted with the pole that the fit is told differ by by_poles from those with the true one.
TEST(PoleErrors, AnErrorOfThePoleShiftsTheAmplitudesAsStated) {
  const ModalChannel::Truth truth{kOpenPole, {{0.7, 0.3}}, 0.0, 4.0};
  ModalChannel right(truth, kOpenPole);
  const Propagated of(right, true, 1e24);
  constexpr double kOff = 1e-5;  // relative, of Re and of Im
  for (const int part : {0, 1}) {
    const Complex by = std::abs(kOpenPole[0]) * (part == 0 ? Complex{kOff, 0.0} : Complex{0.0, kOff});
    ModalChannel wrong(truth, {kOpenPole[0] - by});
    ASSERT_TRUE(wrong.solve(1e3));
    // The truth is the told pole and η.
    const Eigen::Vector2d shift =
        right.solution.amplitude(right.layout(), 0) - wrong.solution.amplitude(wrong.layout(), 0);
    const Eigen::Vector2d stated = kOff * of.effect.by_poles.block<2, 1>(0, part);
    EXPECT_LT((shift - stated).norm(), 0.02 * stated.norm()) << part;
  }
}

TEST(PoleErrors, AFrequencyThatIsOpenIsKnownByTheDataAlone) {
  ModalChannel channel({kOpenPole, {{0.7, 0.3}}, 0.01, 4.0}, kOpenPole);
  ModalChannel same({kOpenPole, {{0.7, 0.3}}, 0.01, 4.0}, kOpenPole);
  const double open = Propagated(channel, true, 1.0).errors.covariance()(2, 2);
  const double given = Propagated(same, true, 1e24).errors.covariance()(2, 2);
  // A line of amplitude 2 in noise σ over T: u_ω = √24 σ / (A T √N), somewhat more with a mode beside it.
  const double bound = std::sqrt(24.0) * 0.01 / (2 * 4.0 * std::sqrt(800.0)) / ModalChannel::kOmega;
  EXPECT_GT(std::sqrt(open), bound);
  EXPECT_LT(std::sqrt(open), 3 * bound);
  EXPECT_NEAR(given, 1e-24, 1e-26);
}

}  // namespace
}  // namespace dwell
