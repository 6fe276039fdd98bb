#include "tests/rigsim/bent_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rigsim {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
const dwell::Chain kChain{dwell::Boundary::clamped, {12, 8}, {24000, 8000, 9000}, {60, 45, 40}};

// A step that a ramp ends in is 1e-5 of the amplitude off.
void expect_equal(const dwell::ChainMotion& a, const dwell::ChainMotion& b, double t_s) {
  for (std::size_t k = 0; k < a.y.size(); ++k) {
    EXPECT_NEAR(a.y[k], b.y[k], 1e-7) << "y" << k << " at " << t_s;
    EXPECT_NEAR(a.velocity[k], b.velocity[k], 1e-5) << "y" << k << "' at " << t_s;
  }
  EXPECT_NEAR(a.ground_force, b.ground_force, 2e-3) << t_s;
}

TEST(BentChain, WithoutBendsIsTheExactChainThroughChangesOfTheDrive) {
  const dwell::Drive drive{4.0, 0.005, 0.001, 0.25, {{3, 0.0002, 0.4}}};
  BentChain bent(kChain, {}, drive, false);
  dwell::DrivenChain exact(kChain, drive, dwell::DrivenChain::Start::rest);
  double t_s = 0.0;
  for (; t_s < 1.5; t_s += 0.0031) expect_equal(bent.at(t_s), exact.at(t_s), t_s);
  const dwell::Drive other{5.0, 0.003, 0.0, 0.1, {}};
  bent.set_drive(t_s, other);
  exact.set_drive(t_s, other);
  for (; t_s < 3.0; t_s += 0.0031) expect_equal(bent.at(t_s), exact.at(t_s), t_s);
}

TEST(BentChain, BegunSteadyIsSteady) {
  const dwell::Drive drive{4.0, 0.005, 0.0, 0.25, {}};
  BentChain bent(kChain, {}, drive, true);
  dwell::DrivenChain exact(kChain, drive, dwell::DrivenChain::Start::steady);
  for (double t_s = 0.0; t_s < 0.5; t_s += 0.0131) {
    const dwell::ChainMotion& a = bent.at(t_s);
    const dwell::ChainMotion& b = exact.at(t_s);
    for (std::size_t k = 0; k < a.y.size(); ++k) EXPECT_NEAR(a.y[k], b.y[k], 1e-6);
  }
}

TEST(BentChain, RemembersWhatItReadBefore) {
  BentChain bent(kChain, {}, {4.0, 0.005, 0.0, 0.0, {}}, false);
  const double before = bent.at(1.0).y[2];
  (void)bent.at(1.5);
  EXPECT_NEAR(bent.at(1.0).y[2], before, 1e-12);
}

TEST(BentChain, ASideSpringToTheTableIsPartOfElementOne) {
  dwell::Chain stiffer = kChain;
  stiffer.stiffness[0] += 900;
  stiffer.damping[0] += 5;
  const dwell::Drive drive{4.0, 0.005, 0.0, 0.25, {}};
  Bend bend;
  bend.side.push_back({1, 0, 900, 5});
  BentChain bent(kChain, bend, drive, false);
  dwell::DrivenChain exact(stiffer, drive, dwell::DrivenChain::Start::rest);
  for (double t_s = 0.0; t_s < 1.0; t_s += 0.01) expect_equal(bent.at(t_s), exact.at(t_s), t_s);
}

TEST(BentChain, ASideSpringToTheGroundIsNotInTheLoadCell) {
  Bend bend;
  bend.side.push_back({2, -1, 900, 0});
  BentChain bent(kChain, bend, {4.0, 0.005, 0.0, 0.25, {}}, false);
  const dwell::ChainMotion& motion = bent.at(2.0);
  EXPECT_NEAR(motion.ground_force, 9000 * motion.y[2] + 40 * motion.velocity[2], 1e-9);
}

// r + 4 F_c / (π ω a) and c + (3/4) c₃ a² (docs/method.md, weak nonlinearity).
TEST(BentChain, FrictionAndACubicSpringAreTheirEquivalents) {
  const dwell::Chain chain{dwell::Boundary::clamped, {}, {2e4}, {40}};
  const double a = 0.002, omega = kTwoPi * 4.0;
  Bend bend;
  bend.elements = {{1, 3.0, 0.0}, {1, 0.0, 1e9}};
  BentChain bent(chain, bend, {4.0, a, 0.0, 0.0, {}}, true);
  double c = 0.0, r = 0.0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const double t_s = (i + 0.5) / kSamples, force = bent.at(t_s).ground_force;
    c += 2 / a * force * std::sin(omega * t_s) / kSamples;
    r += 2 / a / omega * force * std::cos(omega * t_s) / kSamples;
  }
  EXPECT_NEAR(c, 2e4 + 0.75 * 1e9 * a * a, 2);
  EXPECT_NEAR(r, 40 + 4 * 3.0 / (std::numbers::pi * omega * a), 0.2);
}

TEST(BentChain, TheAmplitudeHunts) {
  Bend bend;
  bend.hunt = 0.1;
  bend.hunt_hz = 0.5;
  BentChain bent(kChain, bend, {4.0, 0.005, 0.0, 0.0, {}}, false);
  for (double t_s = 0.0; t_s < 2.0; t_s += 0.017)
    EXPECT_NEAR(bent.at(t_s).y[0], 0.005 * (1 + 0.1 * std::sin(kTwoPi * 0.5 * t_s)) * std::sin(kTwoPi * 4.0 * t_s),
                1e-12);
}

TEST(BentChain, AmplitudeAndFrequencyDriftAndGoOnThroughAChangeOfTheDrive) {
  Bend bend;
  bend.drift = 0.05;
  bend.drift_hz = 0.2;
  BentChain bent(kChain, bend, {4.0, 0.005, 0.0, 0.0, {}}, false);
  const auto table = [](double t_s) {
    return 0.005 * (1 + 0.05 * t_s) * std::sin(kTwoPi * (4.0 + 0.5 * 0.2 * t_s) * t_s);
  };
  for (double t_s = 0.0173; t_s < 3.0; t_s += 0.0173) {
    const dwell::ChainMotion now = bent.at(t_s);
    EXPECT_NEAR(now.y[0], table(t_s), 1e-12);
    EXPECT_NEAR(now.velocity[0], (table(t_s + 1e-5) - table(t_s - 1e-5)) / 2e-5, 1e-8);
    EXPECT_NEAR(now.acceleration[0], (table(t_s + 1e-4) - 2 * table(t_s) + table(t_s - 1e-4)) / 1e-8, 1e-4);
  }
  bent.set_drive(3.0, {4.0, 0.005, 0.0, 0.0, {}});
  EXPECT_NEAR(bent.at(3.5).y[0], table(3.5), 1e-9);
}

TEST(BentChain, SaysWhatTheChainHasNot) {
  Bend bend;
  EXPECT_EQ(bend.fault(kChain), "");
  bend.elements = {{4, 1.0, 0.0}};
  EXPECT_NE(bend.fault(kChain), "");
  bend.elements.clear();
  for (const Bend::SideSpring& spring : {Bend::SideSpring{3, 0, 1, 0}, {1, 1, 1, 0}, {1, 5, 1, 0}}) {
    bend.side = {spring};
    EXPECT_NE(bend.fault(kChain), "");
  }
}

}  // namespace
}  // namespace rigsim
