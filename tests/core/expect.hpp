// What tests of the pipeline expect of a dwell.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/result/dwell.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {

inline Drive steady_drive(double frequency_hz, double amplitude = 0.002) {
  Drive drive;
  drive.frequency_hz = frequency_hz;
  drive.amplitude = amplitude;
  return drive;
}

inline void expect_coefficients(const Dwell& dwell, const Chain& chain, double c_tolerance, double r_tolerance,
                                const std::string& what) {
  ASSERT_EQ(dwell.elements.size(), chain.stiffness.size()) << what;
  for (std::size_t e = 0; e < chain.stiffness.size(); ++e) {
    ASSERT_TRUE(dwell.elements[e].identifiable) << what << ": " << dwell.elements[e].reason;
    EXPECT_NEAR(dwell.elements[e].stiffness.value / chain.stiffness[e], 1.0, c_tolerance) << what << ", c_" << e + 1;
    EXPECT_NEAR(dwell.elements[e].damping.value / chain.damping[e], 1.0, r_tolerance) << what << ", r_" << e + 1;
  }
}

// Each coefficient within `k` of its standard uncertainties.
inline void expect_within(const Dwell& dwell, const Chain& chain, double k, const std::string& what) {
  ASSERT_EQ(dwell.elements.size(), chain.stiffness.size()) << what;
  for (std::size_t e = 0; e < chain.stiffness.size(); ++e) {
    const ElementEstimate& element = dwell.elements[e];
    ASSERT_TRUE(element.identifiable) << what << ", element " << e + 1 << ": " << element.reason;
    EXPECT_LT(std::abs(element.stiffness.value - chain.stiffness[e]), k * element.stiffness.u)
        << what << ", c_" << e + 1;
    EXPECT_LT(std::abs(element.damping.value - chain.damping[e]), k * element.damping.u) << what << ", r_" << e + 1;
  }
}

}  // namespace dwell
