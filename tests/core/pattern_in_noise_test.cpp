#include "core/motion/pattern_in_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/motion/motion_estimate.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

// Of each four readings of the table the last three are as old as the first, noise apart: a register that is refreshed
// less often than it is read. In a steady motion no channel but the table's own shows it.
TEST(PatternInNoise, SaysThatTheTablesReadingsErrInAPattern) {
  std::mt19937_64 rng(16);
  std::normal_distribution<double> normal;
  const Drive drive{4.0, 0.005, 0.0, 0.0};
  for (int draw = 0; draw < 4; ++draw) {
    const Chain chain = random_chain(rng, 1 + draw % 2, draw % 4 < 2 ? Boundary::free : Boundary::clamped, 4.0);
    const Rig rig = rig_of(chain, 4.0);
    const std::vector<double> noise = part_of_steady(rig, chain, drive, 0.002);
    DrivenChain steady(chain, drive, DrivenChain::Start::steady);
    const MotionData sound = readings_of(rig, steady, 0.0, 4.0, 200.0, noise, rng());
    MotionData held = sound;
    double first = 0.0;
    int n = 0;
    for (MotionReading& reading : held.readings) {
      if (reading.channel != 0) continue;
      if (n++ % 4 == 0)
        first = reading.value;
      else
        reading.value = first + noise[0] * normal(rng);
    }
    const MotionEstimate right = estimate_motion(rig, sound), wrong = estimate_motion(rig, held);
    EXPECT_TRUE(right.patterns.empty()) << draw;
    ASSERT_EQ(wrong.patterns.size(), 1U) << draw << " " << wrong.reason;
    EXPECT_EQ(wrong.patterns[0].channel, "y0");
    const std::string words =
        words_of_pattern(wrong.patterns[0]) + ". These ± are wider for it. Those of the dwell are not";
    EXPECT_EQ(words.find("the readings of y0 err in a pattern, by "), 0U) << words;
    EXPECT_NE(std::find(wrong.warnings.begin(), wrong.warnings.end(), words), wrong.warnings.end()) << draw;
    for (std::size_t e = 0; e < wrong.elements.size(); ++e) {
      const ElementEstimate& element = wrong.elements[e];
      if (!element.identifiable) continue;
      EXPECT_LT(std::abs(element.stiffness.value - chain.stiffness[e]), 4 * element.stiffness.u) << draw << " c " << e;
      EXPECT_LT(std::abs(element.damping.value - chain.damping[e]), 4 * element.damping.u) << draw << " r " << e;
    }
  }
}

// Rounding is no pattern of the device: it errs by half a step at most.
TEST(PatternInNoise, TakesCoarseRoundingForNoFaultOfTheTablesReadings) {
  const Chain chain{Boundary::free, {2.0}, {6000.0}, {12.0}};
  const Rig rig = rig_of(chain, 4.0);
  const Drive drive{4.0, 0.005, 0.0, 0.0};
  const std::vector<double> noise = part_of_steady(rig, chain, drive, 3e-4),
                            step = part_of_steady(rig, chain, drive, 0.01);
  DrivenChain steady(chain, drive, DrivenChain::Start::steady);
  MotionData data = readings_of(rig, steady, 0.0, 4.0, 500.0, noise, 5);
  for (MotionReading& reading : data.readings) {
    const double q = step[static_cast<std::size_t>(reading.channel)];
    reading.value = std::round(reading.value / q) * q;
  }
  EXPECT_TRUE(estimate_motion(rig, data).patterns.empty());
}

}  // namespace
}  // namespace dwell
