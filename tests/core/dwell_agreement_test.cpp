#include "core/motion/dwell_agreement.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

ElementEstimate element_with(double c, double u) {
  ElementEstimate element;
  element.identifiable = true;
  element.stiffness = {c, u, 100.0, 2 * u, true};
  element.damping = {10.0, 0.1, 100.0, 0.2, true};
  element.budget = {{"noise of y1", 0.5, 0.5}, {"scale of y1", 0.5, 0.5}};
  return element;
}

struct Pair {
  MotionEstimate motion;
  Dwell dwell;
};
Pair same_data(double c_motion, double c_dwell) {
  Pair out;
  out.motion.start_s = 0.0;
  out.motion.end_s = 10.0;
  out.motion.elements = {element_with(c_motion, 2.0)};
  out.motion.u_of_noise = {1.0, 0.05};
  out.dwell.settled_s = 5.0;
  out.dwell.end_s = 10.0;
  out.dwell.elements = {element_with(c_dwell, 2.0)};
  return out;
}

// Variances by noise: 1 of the motion, 0.5 · 4 = 2 of the dwell; of the difference 2 - 1.
TEST(DwellAgreement, TakesTheDifferenceOfTheVariancesOfTheSameData) {
  const Pair pair = same_data(1000.0, 1003.0);
  EXPECT_NEAR(agreement_e_n(pair.motion, pair.dwell), 3.0 / 2.0, 1e-9);
}

TEST(DwellAgreement, TakesTheirSumWhereTheDwellGoesOn) {
  Pair pair = same_data(1000.0, 1003.0);
  pair.dwell.end_s = 60.0;
  EXPECT_NEAR(agreement_e_n(pair.motion, pair.dwell), 3.0 / (2.0 * std::sqrt(3.0)), 1e-9);
}

TEST(DwellAgreement, SaysNothingOfElementsThatOneOfBothLacks) {
  Pair pair = same_data(1000.0, 1003.0);
  pair.dwell.elements[0].identifiable = false;
  EXPECT_TRUE(std::isnan(agreement_e_n(pair.motion, pair.dwell)));
}

}  // namespace
}  // namespace dwell
