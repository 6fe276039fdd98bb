// Knocked while it settles, a rig is measured soon after the last knock.
#include <gtest/gtest.h>

#include "tests/study/case.hpp"
#include "tests/study/figures.hpp"
#include "tests/study/outcome.hpp"

namespace dwell::study {
namespace {

TEST(StudyKnocks, AKnockAddsItsVelocityAndLeavesTheTableAlone) {
  const Chain chain{Boundary::free, {2.0}, {800.0}, {4.0}};
  Sensor table, position, velocity;
  position.at = velocity.at = 1;
  velocity.measures = Quantity::velocity;
  Motion motion(chain, {table, velocity, position});
  motion.drive(0.0, {3.0, {Complex{0.01, 0.0}, Complex{0.0, 0.002}}});
  const double t_s = 0.777, before[] = {motion.reading(0, 1.5), motion.reading(1, t_s), motion.reading(2, t_s)};
  motion.knock(t_s, 1, 0.3);
  EXPECT_NEAR(motion.reading(0, 1.5), before[0], 1e-12);
  EXPECT_NEAR(motion.reading(1, t_s), before[1] + 0.3, 1e-12);
  EXPECT_NEAR(motion.reading(2, t_s), before[2], 1e-12);
}

// The fit began at the hold's beginning, and left out at most six tenths of it: the verdict came as long after the
// knocks as they had lasted, where it came.
class KnockedRig : public testing::TestWithParam<int> {};  // of the population

TEST_P(KnockedRig, HasItsVerdictSoonAfterTheLastOfManyKnocksAndNotTooEarly) {
  const Outcome outcome = play_dwell(draw(Population::knocks, 1, GetParam()));
  EXPECT_LE(late_by(outcome, 10, 1), 1.0);
  EXPECT_LE(outcome.left, 1.0);
}

INSTANTIATE_TEST_SUITE_P(StudyKnocks, KnockedRig, testing::Values(0, 2, 3, 4, 7));

}  // namespace
}  // namespace dwell::study
