// Driven at a natural frequency, dwells whose modal fit once stopped far from its optimum.
#include <gtest/gtest.h>

#include <cmath>

#include "core/angle.hpp"
#include "tests/study/case.hpp"
#include "tests/study/outcome.hpp"

namespace dwell::study {
namespace {

TEST(StudyResonance, DrivesWithinTheHalfPowerWidthOfALightlyDampedMode) {
  for (int index = 0; index < 30; ++index) {
    const Case about = draw(Population::resonance, 1, index);
    double nearest = INFINITY;
    for (const Complex& pole : about.motion->natural()) {
      const double ratio = -pole.real() / std::abs(pole);
      if (ratio < 0.0018 || ratio > 0.012) continue;
      nearest = std::min(nearest, std::abs(kTwoPi * about.frequency_hz / std::abs(pole) - 1) / ratio);
    }
    EXPECT_LE(nearest, 1.2) << "rig " << index;
  }
}

// Refined poles and frequency that overshoot were thrown away whole: the fit stayed where it was, and said so with
// confidence.
TEST(StudyResonance, SettlesInTimeAndNotTooEarlyWhereAStepOfThePolesOvershoots) {
  for (const int index : {20, 72}) {
    const Outcome outcome = play_dwell(draw(Population::resonance, 1, index));
    EXPECT_TRUE(outcome.settled) << "rig " << index;
    EXPECT_LE(outcome.left, 1.0) << "rig " << index;
  }
}

TEST(StudyResonance, IsNotDoubtedForPolesOfAFitThatHasNotConverged) {
  for (const int index : {1, 58, 65}) EXPECT_FALSE(play_dwell(draw(Population::resonance, 1, index)).doubted);
}

}  // namespace
}  // namespace dwell::study
