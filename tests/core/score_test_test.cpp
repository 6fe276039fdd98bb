#include "core/motion/score_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stop_token>

#include "core/motion/missing_terms.hpp"
#include "core/motion/refit.hpp"
#include "core/motion/unchecked.hpp"
#include "tests/core/faulty_motion.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

struct Judged {
  Rig rig;
  MotionCourse course;
  ScoreTest test;
};

// 10 µm of displacements; of forces 0.1 N, of an element alone 2 N.
std::vector<double> noise_of(const Rig& rig, const Chain& chain) {
  std::vector<double> sigma(rig.channels.size(), 1e-5);
  if (chain.boundary == Boundary::clamped) sigma.back() = chain.masses.empty() ? 2.0 : 0.1;
  return sigma;
}

Judged judged(const Rig& rig, const MotionData& data) {
  Judged out{rig, run_course(rig, data, 10000), {}};
  out.test = score_test(rig, out.course);
  return out;
}

Judged judged(const Chain& chain, double mass_u, std::uint64_t seed) {
  Rig rig = rig_of(chain, 4.0);
  for (const double mass : chain.masses)
    if (mass_u > 0) rig.mass_u.push_back(mass_u * mass);
  return judged(rig, readings_of(rig, FaultyMotion(chain, {}, 0.005), 3.0, 100.0, noise_of(rig, chain), seed));
}

// Of healthy rigs 2 gain is χ² of one degree of freedom, of candidates that are stated and of those that are not.
TEST(ScoreTest, GainsHalfASquareOfHealthyRigs) {
  double sum = 0.0, count = 0.0, largest = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Judged one = judged(free_chain(), 0.0, seed);
    ASSERT_EQ(one.course.reason, "");
    for (Eigen::Index a = 0; a < one.test.sizes.size(); ++a) {
      if (!one.test.told[static_cast<std::size_t>(a)]) continue;
      sum += 2 * one.test.gain(a);
      largest = std::max(largest, one.test.gain(a));
      count += 1;
    }
  }
  EXPECT_GT(count, 100);
  EXPECT_NEAR(sum / count, 1.0, 0.5);  // they are correlated: some twenty independent ones
  EXPECT_LT(largest, 10.0);
}

TEST(ScoreTest, ARefitAndTheLongSearchAreGivenUpWhenNobodyWantsThemAnyMore) {
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, 4.0);
  const MotionData data = readings_of(rig, FaultyMotion(chain, {}, 0.005), 3.0, 100.0, noise_of(rig, chain), 1);
  Judged one = judged(rig, data);
  std::stop_source unwanted;
  one.course.limits.stop = unwanted.get_token();
  unwanted.request_stop();
  const Parameter& term = one.test.candidates.front();
  EXPECT_THROW((void)refit_with(rig, one.course, term, one.test.maximum_with(0, one.course.fit.at), one.test.value(0)),
               Stopped);
  one.course.reason = "did not converge";
  EXPECT_THROW((void)find_missing(rig, data, one.course, true, 10000, true), Stopped);
}

// What the test foretells the fit finds.
TEST(ScoreTest, ForetellsTheFit) {
  const Judged one = judged(clamped_chain(), 0.002, 3);
  ASSERT_EQ(one.course.reason, "");
  for (Eigen::Index a = 0; a < one.test.sizes.size(); ++a) {
    const Parameter& term = one.test.candidates[static_cast<std::size_t>(a)];
    if (!one.test.told[static_cast<std::size_t>(a)] || is_input(term.what)) continue;
    const Refit fit =
        refit_with(one.rig, one.course, term, one.test.maximum_with(a, one.course.fit.at), one.test.value(a));
    ASSERT_TRUE(fit.converged) << name_of(one.rig, term);
    const double u = 1 / std::sqrt(one.test.information(a, a));
    EXPECT_NEAR(fit.gain, one.test.gain(a), 0.1 + 0.1 * one.test.gain(a)) << name_of(one.rig, term);
    EXPECT_NEAR(fit.value, one.test.value(a), 0.2 * u) << name_of(one.rig, term);
  }
}

// A free chain in which all masses are half as heavy again moves alike, and so do all channels of another scale.
TEST(Unchecked, IsTheCommonScaleOfMassesAndOfTransducersOfAFreeChain) {
  const Judged one = judged(free_chain(), 0.001, 1);
  EXPECT_EQ(unchecked(one.rig, one.test),
            (std::vector<std::string>{"the common scale of mass 1 and mass 2", "the common scale of y0, y1 and y2",
                                      "the common delay of y0, y1 and y2"}));
}

TEST(Unchecked, IsEitherScaleWhereNoMassIs) {
  const Judged one = judged({Boundary::clamped, {}, {20000.0}, {300.0}}, 0.0, 1);
  EXPECT_EQ(unchecked(one.rig, one.test),
            (std::vector<std::string>{"scale of y0", "scale of reaction", "the common delay of y0 and reaction"}));
}

// The service was started while the rig was already shaking: neither masses nor instants show in a steady sine.
TEST(Unchecked, IsMostOfAllInASteadyMotion) {
  const Rig rig = rig_of(clamped_chain(), 4.0);
  DrivenChain steady(clamped_chain(), {.frequency_hz = 4.0, .amplitude = 0.005}, DrivenChain::Start::steady);
  const Judged one = judged(rig, readings_of(rig, steady, 0.0, 3.0, 100.0, noise_of(rig, clamped_chain()), 1));
  ASSERT_EQ(one.course.reason, "");
  const std::vector<std::string> what = unchecked(one.rig, one.test);
  ASSERT_EQ(what.size(), 1u);
  EXPECT_NE(what[0].find("this motion tells only 2 of 10 combinations"), std::string::npos) << what[0];
}

}  // namespace
}  // namespace dwell
