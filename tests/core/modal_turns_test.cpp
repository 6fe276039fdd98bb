#include "core/transient/modal_turns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

constexpr double kTurning = 2 * M_PI * 5.0;

void expect_turned(const ModalTurns& turns, const ModalMotion& motion, std::int64_t t_ns, double tolerance) {
  const double u = motion.seconds(t_ns);
  EXPECT_EQ(turns.at_ns(), t_ns);
  EXPECT_LT(std::abs(turns.drive() - std::polar(1.0, motion.angle(t_ns))), tolerance) << t_ns;
  for (std::size_t m = 0; m < motion.count(); ++m)
    EXPECT_LT(std::abs(turns.mode(m) - std::exp(motion.poles()[m] * u)), tolerance) << t_ns << ", mode " << m;
}

TEST(ModalTurns, ManyStepsAreAsGoodAsGoingThereAtOnce) {
  ModalMotion motion(3);
  const std::vector<Complex> poles{{-0.05, 33.0}, {-2.0, 0.0}, {0.0, 314.0}};
  motion.restart(kTurning, 0.0, 1'000'000'000, poles);
  ModalTurns turns;
  std::mt19937_64 rng(1);
  std::int64_t t_ns = 1'000'000'000;
  for (int i = 0; i < 5000; ++i) {
    turns.go(motion, t_ns);
    if (i % 97 == 0) expect_turned(turns, motion, t_ns, 3e-12);
    // Five distances, one more than are kept.
    t_ns += 1'000'000 * static_cast<std::int64_t>(1 + rng() % 5);
  }
}

TEST(ModalTurns, GoesBackAsWell) {
  ModalMotion motion(1);
  const std::vector<Complex> poles{{-0.5, 33.0}};
  motion.restart(kTurning, 0.0, 0, poles);
  ModalTurns turns;
  for (const std::int64_t t_ns : {0, 500'000'000, 200'000'000, 210'000'000, 10'000'000}) {
    turns.go(motion, t_ns);
    expect_turned(turns, motion, t_ns, 1e-12);
  }
}

TEST(ModalTurns, ADriveThatDriftsIsFollowed) {
  ModalMotion motion(1);
  motion.restart(kTurning, 0.3, 0, {});
  ModalTurns turns;
  for (std::int64_t t_ns = 0; t_ns < 10'000'000'000; t_ns += 7'000'000) {
    turns.go(motion, t_ns);
    expect_turned(turns, motion, t_ns, 1e-12);
  }
}

TEST(ModalTurns, WhatHasDecayedIsZero) {
  ModalMotion motion(1);
  const std::vector<Complex> poles{{-10.0, 33.0}};
  motion.restart(kTurning, 0.0, 0, poles);
  ModalTurns turns;
  for (std::int64_t t_ns = 0; t_ns <= 4'000'000'000; t_ns += 10'000'000) turns.go(motion, t_ns);
  EXPECT_EQ(turns.mode(0), Complex{}) << "by steps: exp(-40) is below 1e-13";
  turns.restart();
  turns.go(motion, 4'000'000'000);
  EXPECT_EQ(turns.mode(0), Complex{}) << "at once";
}

TEST(ModalTurns, AnotherMotionStartsAfresh) {
  ModalMotion motion(1);
  const std::vector<Complex> slow{{-0.5, 33.0}}, fast{{-1.0, 80.0}};
  ModalTurns turns;
  for (const auto* poles : {&slow, &fast}) {
    motion.restart(kTurning, 0.0, 0, *poles);
    turns.restart();
    for (std::int64_t t_ns = 0; t_ns < 1'000'000'000; t_ns += 5'000'000) turns.go(motion, t_ns);
    expect_turned(turns, motion, 995'000'000, 1e-12);
  }
}

TEST(ModalMotion, TakesAsManyPolesAsItHasRoomFor) {
  ModalMotion motion(2);
  const std::vector<Complex> poles{{-3.0, 4.0}, {0.0, 10.0}, {-1.0, 0.0}};
  motion.restart(kTurning, 0.0, 0, poles);
  ASSERT_EQ(motion.count(), 2u);
  EXPECT_EQ(motion.poles()[1], poles[1]);
  EXPECT_DOUBLE_EQ(motion.size(0), 5.0);
  EXPECT_TRUE(motion.decays(0));
  EXPECT_FALSE(motion.decays(1)) << "a steady line";
  EXPECT_EQ(ModalMotion(99).capacity(), static_cast<std::size_t>(ModalMotion::kMaxModes));
}

TEST(ModalMotion, MayBeRestartedWithItsOwnPoles) {
  ModalMotion motion(3);
  const std::vector<Complex> poles{{-3.0, 4.0}, {0.0, 10.0}, {-1.0, 0.0}};
  motion.restart(kTurning, 0.0, 0, poles);
  motion.restart(2 * kTurning, 0.0, 7, motion.poles().first(2));
  ASSERT_EQ(motion.count(), 2u);
  EXPECT_EQ(motion.poles()[0], poles[0]);
  EXPECT_DOUBLE_EQ(motion.omega(), 2 * kTurning);
  EXPECT_EQ(motion.t0_ns(), 7);
}

TEST(ModalMotion, TheAngleOfADriftingDriveIsTheIntegralOfItsFrequency) {
  ModalMotion motion(1);
  motion.restart(10.0, 2.0, 1'000'000'000, {});
  EXPECT_DOUBLE_EQ(motion.seconds(4'000'000'000), 3.0);
  EXPECT_DOUBLE_EQ(motion.angle(4'000'000'000), 10.0 * 3 + 0.5 * 2 * 9);
}

}  // namespace
}  // namespace dwell
