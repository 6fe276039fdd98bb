#include "core/motion/inflated_process.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/model/forward.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

// Hausman: both fits of a right chain differ by chance. Four standard deviations: 1 in 16 000 of some forty values. The
// search leaves 0.03 of a standard deviation, so a difference of less than 0.1 of one is not judged by its own.
TEST(InflatedProcess, LeavesARightChainWhereItIs) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  const Drive drive{4.0, 0.005, 0.0, 0.3};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    DrivenChain driven(chain, drive, DrivenChain::Start::rest);
    const MotionCourse course = run_course(
        rig, readings_of(rig, driven, 0.0, 2.0, 200.0, part_of_steady(rig, chain, drive, 0.003), seed, 2e-4), 14'000);
    ASSERT_EQ(course.reason, "");
    const MotionCourse inflated = with_inflated_process_noise(rig, course);
    ASSERT_TRUE(inflated.fit.converged);
    EXPECT_GT(inflated.fit.V, course.fit.V) << "the intensities of the course are the likeliest";
    for (std::size_t i = 0; i < course.parameters.size(); ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      const double by = inflated.fit.at.theta(a) - course.fit.at.theta(a);
      const double variance = inflated.fit.covariance(a, a) - course.fit.covariance(a, a);
      switch (course.parameters[i].what) {
        case Unknown::intensity:
          EXPECT_GE(by, std::log(99.0));
          break;
        case Unknown::noise:
          EXPECT_GE(by, 0.0);
          break;
        default:
          EXPECT_LT(std::abs(by), 4 * std::sqrt(std::max(variance, 0.01 * course.fit.covariance(a, a)))) << seed << i;
      }
    }
  }
}

}  // namespace
}  // namespace dwell
