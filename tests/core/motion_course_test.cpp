// The way to the largest likelihood: where it could come to rest beside it.
#include "core/motion/motion_course.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/motion/unknowns.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/faulty_motion.hpp"

namespace dwell {
namespace {

// A table whose amplitude rises slowly from 0: A sin²(πt/T) sin(ωt).
struct Swell {
  static constexpr double kHz = 5.0, kTop = 1e-3, kLasts_s = 4.0;
  static double at(double t) {
    const double swell = std::sin(kTwoPi * t / (2 * kLasts_s));
    return kTop * swell * swell * std::sin(kTwoPi * kHz * t);
  }
};

// The table and one mass behind an element, from rest, by fourth-order steps of Runge and Kutta; 22 readings a
// period, the mass read 2 ms after the table.
MotionData readings_of_swell(const Chain& chain, double noise, std::uint64_t seed) {
  const double c = chain.stiffness[0], r = chain.damping[0], m = chain.masses[0];
  constexpr double kStep_s = 1e-4, kNear_s = 1e-5;
  const auto pull = [&](double t, double y, double v) {
    const double v0 = (Swell::at(t + kNear_s) - Swell::at(t - kNear_s)) / (2 * kNear_s);
    return (c * (Swell::at(t) - y) + r * (v0 - v)) / m;
  };
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  MotionData data;
  double y = 0.0, v = 0.0;
  for (int i = 0; i * kStep_s < 20 / Swell::kHz; ++i) {
    const double t = i * kStep_s, h = kStep_s;
    if (i % 90 == 0) data.readings.push_back({to_ns(t), 0, Swell::at(t) + noise * Swell::kTop * normal(random)});
    if (i % 90 == 20) data.readings.push_back({to_ns(t), 1, y + noise * Swell::kTop * normal(random)});
    const double a1 = pull(t, y, v), v2 = v + h / 2 * a1, a2 = pull(t + h / 2, y + h / 2 * v, v2);
    const double v3 = v + h / 2 * a2, a3 = pull(t + h / 2, y + h / 2 * v2, v3);
    const double v4 = v + h * a3, a4 = pull(t + h, y + h * v3, v4);
    y += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return data;
}

// The likelihood hardly depends on an intensity that is next to nothing: a search that comes there stays. Here it came
// to rest 59 … 68 below the maximum. Tolerance: what FitLimits::gain leaves open.
TEST(MotionCourse, ComesToTheMaximumThatTheTruthLeadsToWhereATableBeginsSlowly) {
  const Chain chain{Boundary::free, {2.0}, {2.0 * std::pow(kTwoPi * 7.0, 2)}, {2 * 0.03 * 2.0 * kTwoPi * 7.0}};
  const Rig rig = rig_of(chain, Swell::kHz);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    constexpr double kNoise = 2e-4;  // of the amplitude
    const MotionCourse course = run_course(rig, readings_of_swell(chain, kNoise, seed), 100'000);
    ASSERT_EQ(course.reason, "");
    MotionUnknowns truth = course.fit.at;
    for (std::size_t a = 0; a < course.parameters.size(); ++a) {
      const Parameter& p = course.parameters[a];
      double& value = truth.theta(static_cast<Eigen::Index>(a));
      if (p.what == Unknown::stiffness) value = chain.stiffness[0];
      if (p.what == Unknown::damping) value = chain.damping[0];
      if (p.what == Unknown::noise) value = std::log(kNoise * Swell::kTop);
      if (p.what == Unknown::intensity) value = std::max(value, -22.0);  // as slowly as it rises, of 1 mm
    }
    const MotionFit from_truth =
        fit_motion(MotionModel(rig, course.parameters), course.data, std::move(truth), course.limits);
    ASSERT_TRUE(from_truth.converged);
    EXPECT_LT(course.fit.V - from_truth.V, 0.01) << "seed " << seed;
  }
}

// The likelihood has a lesser maximum where all intensities are too low. There the table's second tone counts as noise,
// which comes out 22 times too large. At the right maximum it is right; the bound of three times tells the two.
TEST(MotionCourse, TakesNoSecondToneOfTheTableForNoise) {
  const Chain chain{Boundary::clamped, {}, {2e4}, {40}};
  const Rig rig = rig_of(chain, 4.0);
  constexpr double kOfDrive = 0.005, kNoise = 0.013 * kOfDrive;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const FaultyMotion motion(chain, {}, kOfDrive, {{4.0, 1.0}, {6.1, 0.4}});
    const MotionCourse course =
        run_course(rig, readings_of(rig, motion, 3.3, 48.0, {kNoise, kNoise * chain.stiffness[0]}, seed), 100'000);
    ASSERT_EQ(course.reason, "");
    for (std::size_t a = 0; a < course.parameters.size(); ++a) {
      if (course.parameters[a].what != Unknown::noise || course.parameters[a].index != 0) continue;
      EXPECT_LT(std::exp(course.fit.at.theta(static_cast<Eigen::Index>(a))), 3 * kNoise) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace dwell
