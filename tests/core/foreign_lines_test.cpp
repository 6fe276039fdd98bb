// What swings beside the drive and the chain.
#include "core/transient/foreign_lines.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

constexpr double kFiftyHz = kTwoPi * 50.0;

// One line of that amplitude in channel 1.
FreeMotion::Beside line(Complex pole, double amplitude) {
  return [=](int c, double t) { return c == 1 ? amplitude * std::exp(pole * t).real() : 0.0; };
}

// The line found is a pole beside the chain's; the fit is then made by all.
void fit_found(SearchedMotion& motion) {
  auto& best = motion.search.best();
  best.insert(best.begin(), motion.search.poles().beside.front());
  motion.search.refine(motion.search.fit_best(FreeMotion::kDrive, motion.now()), PoleSearch::kManySteps, motion.now());
  motion.search.take_best();
}

TEST(ForeignLines, FindsABracketThatRings) {
  const Complex ring{-0.7, 110.0};
  SearchedMotion motion(1, {});
  motion.play(6, line(ring, 0.02));
  motion.begin(0.2, {}, {FreeMotion::kMode});
  ASSERT_TRUE(motion.lines.find(motion.now()));
  fit_found(motion);
  EXPECT_LT(std::abs(motion.search.poles().beside[0] - ring), 4 * motion.fit.fit().u_pole(0));
  motion.lines.judge(motion.now());
  EXPECT_FALSE(motion.search.poles().hums());
}

TEST(ForeignLines, FindsNothingInNoise) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SearchedMotion motion(seed, {});
    motion.play(4);
    motion.begin(0.2, {}, {FreeMotion::kMode});
    EXPECT_FALSE(motion.lines.find(motion.now())) << seed;
  }
}

TEST(ForeignLines, TakesHumForASteadyLine) {
  SearchedMotion motion(2, {});
  motion.play(6, line({0.0, kFiftyHz}, 0.01));
  motion.begin(0.2, {}, {FreeMotion::kMode});
  ASSERT_TRUE(motion.lines.find(motion.now()));
  fit_found(motion);
  motion.lines.judge(motion.now());
  EXPECT_TRUE(motion.search.poles().hums());
  EXPECT_NEAR(motion.search.poles().beside[0].imag(), kFiftyHz, 4 * motion.fit.fit().u_pole(0));
}

TEST(ForeignLines, WhatDecaysAtTheMainsFrequencyIsNoHum) {
  const Complex ring{-0.8, kFiftyHz};
  SearchedMotion motion(3, {});
  motion.play(6, line(ring, 0.02));
  motion.begin(0.2, {{0.0, kFiftyHz}}, {FreeMotion::kMode});
  EXPECT_TRUE(motion.search.poles().hums());
  motion.lines.judge(motion.now());
  EXPECT_FALSE(motion.search.poles().hums());
  EXPECT_LT(std::abs(motion.search.poles().beside[0] - ring), 4 * motion.fit.fit().u_pole(0));
}

TEST(ForeignLines, AHarmonicOfTheDriveAboveThoseFittedIsSteady) {
  SearchedMotion motion(4, {});
  const Complex fifth{0.0, 5 * FreeMotion::kDrive};
  motion.play(6, line(fifth, 0.01));
  motion.begin(0.2, {{-0.1, fifth.imag()}}, {FreeMotion::kMode});
  motion.lines.judge(motion.now());
  EXPECT_TRUE(motion.search.poles().hums());
}

TEST(ForeignLines, DoesNotAddAThirdPole) {
  SearchedMotion motion(5, {});
  motion.play(6, line({0.0, kFiftyHz}, 0.01));
  motion.begin(0.2, {{-0.5, 110.0}, {-0.5, 130.0}}, {FreeMotion::kMode});
  EXPECT_FALSE(motion.lines.find(motion.now()));
  EXPECT_EQ(motion.search.poles().beside.size(), 2u);
}

}  // namespace
}  // namespace dwell
