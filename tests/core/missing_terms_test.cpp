// What is missing, by name, through the estimate that reports it.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/motion/motion_estimate.hpp"
#include "core/motion/refit.hpp"
#include "tests/core/faulty_motion.hpp"
#include "tests/core/motion_case.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

constexpr double kAmplitude = 0.005;

// Noise of 2e-3 of the table's motion; of the force as much of what the ground's element bears.
std::vector<double> noise_of(const Rig& rig, const Chain& chain) {
  std::vector<double> sigma;
  for (const Channel& channel : rig.channels)
    sigma.push_back(2e-3 * kAmplitude * (channel.measures == Quantity::force ? chain.stiffness.back() : 1.0));
  return sigma;
}

MotionEstimate estimate_with(const Chain& chain, const Rig& rig, const Faults& faults, std::uint64_t seed) {
  return estimate_motion(
      rig, readings_of(rig, FaultyMotion(chain, faults, kAmplitude), 3.0, 150.0, noise_of(rig, chain), seed));
}

// Whether a term is among those that are named as the same.
bool named(const MotionEstimate& estimate, const std::string& what) {
  return std::any_of(estimate.missing.begin(), estimate.missing.end(),
                     [&](const MissingTerm& term) { return term.what == what; });
}

std::string told(const MotionEstimate& estimate) {
  std::string text = estimate.reason;
  for (const MissingTerm& term : estimate.missing)
    text += "\n" + term.what + " " + std::to_string(term.value) + " ± " + std::to_string(term.u) + " " + term.unit +
            ", gain " + std::to_string(term.gain) + ": " + term.told;
  for (const std::string& one : estimate.unchecked) text += "\nunchecked: " + one;
  for (const std::string& one : estimate.warnings) text += "\nwarning: " + one;
  return text;
}

TEST(MissingTerms, NamesADamperFromAMassToGroundWithItsValue) {
  for (const Chain& chain : {free_chain(), clamped_chain()}) {
    const Rig rig = rig_of(chain, 4.0);
    const double size = 0.05 * chain.masses[0] * kTwoPi * 4.0;
    const MotionEstimate found = estimate_with(chain, rig, {.ground_damping = size}, 1);
    ASSERT_FALSE(found.missing.empty()) << told(found);
    EXPECT_EQ(found.missing.front().what, "damping of mass 1 to ground") << told(found);
    EXPECT_EQ(found.missing.front().unit, "N*s/m");
    EXPECT_NEAR(found.missing.front().value, size, 4 * found.missing.front().u);
    EXPECT_GT(found.missing.front().gain, 100);
  }
}

TEST(MissingTerms, NamesASpringToGround) {
  const Chain chain = free_chain();
  const double spring = 0.05 * chain.masses[1] * std::pow(kTwoPi * 4.0, 2);
  const MotionEstimate found = estimate_with(chain, rig_of(chain, 4.0), {.mass = 2, .ground_stiffness = spring}, 2);
  EXPECT_TRUE(named(found, "spring of mass 2 to ground")) << told(found);
}

TEST(MissingTerms, NamesASpringPastAMassWithItsValue) {
  for (const Chain& chain : {free_chain(), clamped_chain()}) {
    const double spring = 0.05 * chain.stiffness[1];
    const MotionEstimate found = estimate_with(chain, rig_of(chain, 4.0), {.mass = 2, .table_stiffness = spring}, 9);
    ASSERT_TRUE(named(found, "spring between the table and mass 2")) << told(found);
    EXPECT_EQ(found.missing.front().unit, "N/m");
    EXPECT_NEAR(found.missing.front().value, spring, 4 * found.missing.front().u) << told(found);
    EXPECT_NE(found.missing.front().told.find("a spring of "), std::string::npos) << told(found);
  }
}

TEST(MissingTerms, NamesFrictionWithItsValue) {
  const Chain chain = free_chain();
  const double friction = 0.03 * chain.stiffness[0] * kAmplitude;
  const MotionEstimate found = estimate_with(chain, rig_of(chain, 4.0), {.element = 1, .friction = friction}, 3);
  ASSERT_TRUE(named(found, "friction in element 1")) << told(found);
  EXPECT_NEAR(found.missing.front().value, friction, 0.1 * friction) << told(found);
}

TEST(MissingTerms, NamesACubicStiffnessWithItsValue) {
  const Chain chain = clamped_chain();
  const double cubic = 0.05 * chain.stiffness[1] / (kAmplitude * kAmplitude);
  const MotionEstimate found = estimate_with(chain, rig_of(chain, 4.0), {.element = 2, .cubic = cubic}, 4);
  ASSERT_TRUE(named(found, "cubic stiffness of element 2")) << told(found);
  EXPECT_NEAR(found.missing.front().value, cubic, 0.1 * cubic) << told(found);
}

TEST(MissingTerms, NamesAMassAScaleAndADelay) {
  if (kUnderSanitizer) GTEST_SKIP() << "takes minutes there; VerificationCauses runs the same search";
  const Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4.0);
  rig.mass_u = {0.001 * chain.masses[0], 0.001 * chain.masses[1]};
  for (Channel& channel : rig.channels) channel.scale_u = 5e-4;
  for (Channel& channel : rig.channels) channel.delay_u_s = 2e-6;
  Rig heavy = rig;
  heavy.masses[1] *= 0.9;
  const MotionEstimate mass = estimate_with(chain, heavy, {}, 5);
  ASSERT_TRUE(named(mass, "mass 2")) << told(mass);
  EXPECT_NEAR(mass.missing.front().value, chain.masses[1], 4 * mass.missing.front().u + 0.02) << told(mass);
  Rig loud = rig;
  loud.channels[3].scale = 1.0;
  MotionData data = readings_of(rig, FaultyMotion(chain, {}, kAmplitude), 3.0, 150.0, noise_of(rig, chain), 6);
  for (MotionReading& reading : data.readings)
    if (reading.channel == 3) reading.value *= 1.03;
  const MotionEstimate scale = estimate_motion(loud, data);
  ASSERT_TRUE(named(scale, "scale of reaction")) << told(scale);
  for (MotionReading& reading : data.readings) {
    if (reading.channel == 3) reading.value /= 1.03;
    if (reading.channel == 2) reading.t_ns += 1'000'000;
  }
  std::stable_sort(data.readings.begin(), data.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  const MotionEstimate delay = estimate_motion(rig, data);
  ASSERT_TRUE(named(delay, "delay of y2")) << told(delay);
}

// A model of first order in the delay takes half of it for damping: r/c = δ/2 with a delay of δ/2 leaves |F/y_0| flat,
// as the true delay does.
TEST(MissingTerms, NamesADelayOfTheTableWithItsValueWhereNoMassTellsItFromDamping) {
  const Chain chain{Boundary::clamped, {}, {2e4}, {40}};
  const Rig rig = rig_of(chain, 4.0);
  const double late_s = 0.015;
  MotionData data = readings_of(rig, FaultyMotion(chain, {}, kAmplitude, {{4.0, 1.0}, {2.7, 0.4}}), 5.0, 200.0,
                                noise_of(rig, chain), 8);
  const MotionEstimate found = estimate_motion(rig, shifted(std::move(data), 0, late_s));
  ASSERT_TRUE(named(found, "delay of y0")) << told(found);
  const MissingTerm& term = *std::find_if(found.missing.begin(), found.missing.end(),
                                          [](const MissingTerm& one) { return one.what == "delay of y0"; });
  EXPECT_NEAR(term.value, late_s, 2 * term.u) << told(found);
}

MotionData reversed(MotionData data, int c) {
  for (MotionReading& reading : data.readings)
    if (reading.channel == c) reading.value *= -1;
  return data;
}

MotionData swapped(MotionData data, int a, int b) {
  for (MotionReading& reading : data.readings) {
    if (reading.channel == a)
      reading.channel = b;
    else if (reading.channel == b)
      reading.channel = a;
  }
  return data;
}

TEST(MissingTerms, NamesAReversedLoadCellAndSwappedChannels) {
  if (kUnderSanitizer) GTEST_SKIP() << "takes minutes there; VerificationCauses runs the same search";
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  const MotionData data = readings_of(rig, FaultyMotion(chain, {}, kAmplitude), 2.0, 100.0, noise_of(rig, chain), 7);
  const MotionEstimate sign = estimate_motion(rig, reversed(data, 3));
  ASSERT_TRUE(named(sign, "sign of reaction")) << told(sign);
  EXPECT_NE((sign.reason + told(sign)).find("; the opposite sign of reaction explains it"), std::string::npos)
      << told(sign);
  const MotionEstimate two = estimate_motion(rig, swapped(data, 1, 2));
  ASSERT_TRUE(named(two, "y1 and y2 swapped")) << told(two);
}

TEST(MissingTerms, SaysNothingOfAHealthyRigButWhatItCannotTell) {
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, 4.0);
  for (std::uint64_t seed = 1; seed < static_cast<std::uint64_t>(draws(6, 2)); ++seed) {
    const MotionEstimate found = estimate_with(chain, rig, {}, seed);
    EXPECT_EQ(found.reason, "");
    EXPECT_TRUE(found.missing.empty()) << told(found);
    EXPECT_TRUE(found.warnings.empty()) << told(found);
    EXPECT_EQ(found.unchecked,
              (std::vector<std::string>{"the common scale of mass 1 and mass 2", "the common scale of y0, y1 and y2",
                                        "the common delay of y0, y1 and y2"}))
        << told(found);
  }
}

}  // namespace
}  // namespace dwell
