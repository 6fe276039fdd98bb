#include "core/motion/weak_form.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

// The readings have no noise. The tolerance is what a cubic through readings at 200 Hz misses of the fastest mode.
void expect_clamped_chain(const WeakForm& found) {
  for (int e = 0; e < 3; ++e) {
    const auto i = static_cast<std::size_t>(e);
    EXPECT_NEAR(found.stiffness(e), clamped_chain().stiffness[i], 2e-3 * clamped_chain().stiffness[i]) << e;
    EXPECT_NEAR(found.damping(e), clamped_chain().damping[i], 2e-2 * clamped_chain().damping[i]) << e;
  }
}

// Velocity at mass 1, acceleration at mass 2, a transducer across element 2, irregular instants: no noise.
TEST(WeakForm, FindsTheCoefficientsOfAStartUpFromAnyTransducers) {
  Rig rig = rig_of(clamped_chain(), 4.0);
  rig.channels[1].measures = Quantity::velocity;
  rig.channels[2].measures = Quantity::acceleration;
  rig.channels[3].force_on_mass = true;
  DrivenChain driven(clamped_chain(), {4.0, 0.005, 0.002, 0.4}, DrivenChain::Start::rest);
  MotionData data = readings_of(rig, driven, 0.0, 2.0, 200.0, {0, 0, 0, 0}, 1, 3e-4);
  const WeakForm found = weak_form(rig, data);
  expect_clamped_chain(found);
}

TEST(WeakForm, GivesTheOneElementBetweenTableAndLoadCell) {
  const Chain chain{Boundary::clamped, {}, {50000.0}, {120.0}};
  const Rig rig = rig_of(chain, 8.0);
  DrivenChain driven(chain, {8.0, 0.001, 0.0, 0.3}, DrivenChain::Start::rest);
  const WeakForm found = weak_form(rig, readings_of(rig, driven, 0.0, 1.0, 400.0, {0, 0}, 1));
  EXPECT_NEAR(found.stiffness(0), 50000.0, 50.0);
  EXPECT_NEAR(found.damping(0), 120.0, 1.2);
}

// Noise of the deformation makes the coefficients too small (H1 of modal testing), noise of the force too large (H2).
TEST(WeakForm, HasTheTruthBetweenItselfAndWhatItsCoherenceMakesOfIt) {
  const Chain chain{Boundary::clamped, {}, {50000.0}, {120.0}};
  const Rig rig = rig_of(chain, 8.0);
  const Drive drive{8.0, 0.001, 0.0, 0.0};
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    DrivenChain driven(chain, drive, DrivenChain::Start::steady);
    const WeakForm found =
        weak_form(rig, readings_of(rig, driven, 0.0, 2.0, 80.0, part_of_steady(rig, chain, drive, 0.5), seed));
    EXPECT_LT(found.stiffness(0), 0.97 * chain.stiffness[0]) << seed;
    EXPECT_GT(found.stiffness(0) / found.coherence(0), 1.03 * chain.stiffness[0]) << seed;
  }
}

// Two periods without readings: a cubic through what is on both sides is no motion.
TEST(WeakForm, FindsThemBesideAGapInTheReadings) {
  const Rig rig = rig_of(clamped_chain(), 4.0);
  DrivenChain driven(clamped_chain(), {4.0, 0.005, 0.002, 0.4}, DrivenChain::Start::rest);
  MotionData data = readings_of(rig, driven, 0.0, 3.0, 200.0, {0, 0, 0, 0}, 1, 3e-4);
  std::erase_if(data.readings, [](const MotionReading& r) { return r.t_ns > to_ns(1.1) && r.t_ns < to_ns(1.6); });
  const WeakForm found = weak_form(rig, data);
  expect_clamped_chain(found);
}

TEST(WeakForm, HasNoNumberWhereEveryWindowHasAGap) {
  const Rig rig = rig_of(clamped_chain(), 4.0);
  DrivenChain driven(clamped_chain(), {4.0, 0.005, 0.002, 0.4}, DrivenChain::Start::rest);
  MotionData data = readings_of(rig, driven, 0.0, 1.0, 200.0, {0, 0, 0, 0}, 1, 3e-4);
  std::erase_if(data.readings, [](const MotionReading& r) { return r.t_ns > to_ns(0.1) && r.t_ns < to_ns(0.8); });
  EXPECT_TRUE(std::isnan(weak_form(rig, data).stiffness(0)));
}

// Fewer than five readings a period are the channel's own rate, not gaps.
TEST(WeakForm, TakesSlowReadingsForNoGaps) {
  const Rig rig = rig_of(clamped_chain(), 4.0);
  DrivenChain driven(clamped_chain(), {4.0, 0.005, 0.002, 0.4}, DrivenChain::Start::rest);
  EXPECT_TRUE(std::isfinite(weak_form(rig, readings_of(rig, driven, 0.0, 4.0, 18.0, {0, 0, 0, 0}, 1)).stiffness(0)));
}

TEST(WeakForm, HasNoNumberWhereNoWindowFits) {
  const Rig rig = rig_of(free_chain(), 4.0);
  DrivenChain driven(free_chain(), {4.0, 0.005, 0.0, 0.0}, DrivenChain::Start::rest);
  EXPECT_TRUE(std::isnan(weak_form(rig, readings_of(rig, driven, 0.0, 0.02, 200.0, {0, 0, 0}, 1)).stiffness(0)));
}

}  // namespace
}  // namespace dwell
