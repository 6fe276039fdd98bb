#include "core/base/student.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace dwell {
namespace {

TEST(Student, GivesTheTabulatedFactors) {
  // JCGM 100:2008, table G.2, p = 95 %, rounded there to two decimals; more digits from the exact distribution.
  EXPECT_NEAR(student_t95(1), 12.7062047, 1e-6);
  EXPECT_NEAR(student_t95(2), 4.30265273, 1e-7);
  EXPECT_NEAR(student_t95(5), 2.57058184, 1e-7);
  EXPECT_NEAR(student_t95(10), 2.22813885, 1e-7);
  EXPECT_NEAR(student_t95(50), 2.00855911, 1e-7);
  EXPECT_NEAR(student_t95(1000), 1.96233908, 1e-7);
  EXPECT_NEAR(student_t95(1e7), 1.95996421, 1e-7);
  EXPECT_NEAR(student_t95(std::numeric_limits<double>::infinity()), 1.95996398, 1e-8);
}

TEST(Student, FallsSteadilyWithTheDegreesOfFreedom) {
  double before = student_t95(1);
  for (double dof = 1.1; dof < 3e6; dof *= 1.1) {
    const double now = student_t95(dof);
    ASSERT_LT(now, before) << dof;
    before = now;
  }
}

}  // namespace
}  // namespace dwell
