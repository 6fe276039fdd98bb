// Driven at a natural frequency, dwells whose modal fit once stopped far from its optimum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/angle.hpp"
#include "core/dwell/pipeline.hpp"
#include "tests/study/case.hpp"
#include "tests/study/outcome.hpp"
#include "tests/study/recording.hpp"

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

// The largest transient from t on, over what is allowed.
double left_at(const Case& about, double t_s) {
  double left = 0.0;
  for (int c = 0; c < about.channels(); ++c)
    left = std::max(left, about.motion->largest_from(c, t_s) / about.threshold(c));
  return left;
}

// Noise of a tenth of the amplitude hides a transient that grows apart from the steady motion as slowly as it decays:
// the verdict comes too early, and a later fit shows it.
TEST(StudyResonance, TakesBackAPrematureVerdictAndSettlesInTheSameDwell) {
  for (const int dwell : {30, 38, 77, 147}) {
    Case about = draw(Population::resonance, 1, dwell);
    for (int c = 0; c < about.channels(); ++c)
      about.lines[static_cast<std::size_t>(c)].sigma = 0.1 * std::abs(about.motion->phasor(c, 1));
    Pipeline pipeline(about.rig);
    Player player(about);
    int verdicts = 0, taken_back = 0;
    double last_left = 0.0;
    std::optional<int> index;
    const double end_s = about.change_s + 8 * about.motion->time_constant_s();
    while (player.now_s() < end_s) {
      const std::uint8_t changes = pipeline.push(player.next());
      if (player.now_s() < about.change_s + 2 * about.period_s() || !(changes & kStateChanged)) continue;
      const Dwell now = pipeline.current();
      if (now.state == State::measuring) {
        last_left = left_at(about, player.now_s());
        if (++verdicts == 1) {
          EXPECT_GT(last_left, 10.0);
          index = now.index;
        }
      } else if (verdicts > 0) {
        ++taken_back;
        EXPECT_EQ(now.state, State::settling);
        EXPECT_FALSE(changes & kCompleted);
        EXPECT_NE(now.settling_reason.find("was premature"), std::string::npos) << now.settling_reason;
        EXPECT_TRUE(now.elements.empty());
      }
      EXPECT_TRUE(!index || now.index == index);
    }
    EXPECT_EQ(taken_back, 1) << "rig " << dwell;
    EXPECT_EQ(verdicts, 2) << "rig " << dwell;
    EXPECT_LE(last_left, 1.0) << "rig " << dwell;
  }
}

}  // namespace
}  // namespace dwell::study
