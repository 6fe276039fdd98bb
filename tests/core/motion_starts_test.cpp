// Where the search of core/motion/motion_course.cpp begins: it must come to the same end from a poor start.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/model/forward.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/rig/transducer.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

void expect_coefficients(const MotionEstimate& found, const Chain& chain, double times_u) {
  ASSERT_EQ(found.reason, "");
  for (std::size_t e = 0; e < chain.stiffness.size(); ++e) {
    const ElementEstimate& element = found.elements[e];
    ASSERT_TRUE(element.identifiable) << element.reason;
    EXPECT_LT(std::abs(element.stiffness.value - chain.stiffness[e]), times_u * element.stiffness.u) << e;
    EXPECT_LT(std::abs(element.damping.value - chain.damping[e]), times_u * element.damping.u) << e;
  }
}

// While the table moves as a pure sine, the intensity of its process falls to next to nothing. Just before the 400th
// reading the amplitude falls to a fifth. From that intensity the search of more readings came to no end.
TEST(MotionStarts, ComeToTheCoefficientsWhereAPureSineEndsSuddenly) {
  const Chain chain{Boundary::clamped, {8.67951, 9.62503}, {31489.4, 15715.3, 5706.0}, {85.0834, 118.977, 32.1}};
  const Rig rig = rig_of(chain, 4.0);
  const double rate_hz = 72.5, ends_s = 1.3751;
  const Drive drive{4.0, 0.005, 0.0, 0.0}, less{4.0, -0.004, 0.0, 0.0};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    DrivenChain driven(chain, drive, DrivenChain::Start::steady), change(chain, less, DrivenChain::Start::rest);
    MotionData data = readings_of(rig, driven, 0.0, 5.4, rate_hz, part_of_steady(rig, chain, drive, 0.01), seed, 2e-4);
    for (MotionReading& reading : data.readings)
      if (const double t = to_s(reading.t_ns) - ends_s; t > 0)
        reading.value += exact_reading(rig, change.at(t), reading.channel);
    expect_coefficients(estimate_motion(rig, data), chain, 4.0);
  }
}

}  // namespace
}  // namespace dwell
