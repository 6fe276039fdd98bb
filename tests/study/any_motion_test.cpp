#include "tests/study/any_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace dwell::study {
namespace {

// Near a resonance the table decides. Of one that is read a few times a period the process took up the noise, which
// came out as zero, and the uncertainties were those of a table without noise. Of 600 rigs these two were 6 and 9 u
// off, one without a word, the other beside wrong advice.
TEST(AnyMotion, CountsTheNoiseOfATableWhoseProcessWouldTakeItUp) {
  for (const auto& [seed, index] : {std::pair{1, 176}, std::pair{2, 160}}) {
    const MotionOutcome outcome = play_motion(draw_motion_case(TableKind::sparse, seed, index, 3), 20);
    EXPECT_EQ(outcome.reason, "");
    EXPECT_EQ(outcome.advised, 0);
    EXPECT_EQ(outcome.errors.size(), 2U);
    for (const double error : outcome.errors) EXPECT_LT(std::abs(error), 5.0) << index;
  }
}

// The search came to no end in these two healthy rigs. In the first one the weak form gives half of each coefficient:
// 98 % of a channel was left over, and a scale of 0.36 was advised. In the second one the first readings hardly tell
// the damping: a spring was advised.
TEST(AnyMotion, ComesToTheCoefficientsFromAPoorStart) {
  for (const int index : {26, 71}) {
    const MotionOutcome outcome = play_motion(draw_motion_case(TableKind::dwell, 1, index, 3), 20);
    EXPECT_EQ(outcome.reason, "") << index;
    EXPECT_EQ(outcome.advised, 0) << index;
    EXPECT_EQ(outcome.errors.size(), 4U) << index;
    for (const double error : outcome.errors) EXPECT_LT(std::abs(error), 4.0) << index;
  }
}

}  // namespace
}  // namespace dwell::study
