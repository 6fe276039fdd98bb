// A friction damper, simulated and real: ramps, a hold of three periods, a force far from linear.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "core/dwell/pipeline.hpp"

namespace dwell {
namespace {

// A friction damper between table and load cell, driven at 1 Hz: two seconds of ramp, barely three periods of hold, a
// ramp down that the recording may not see the end of.
class FrictionDamper {
 public:
  FrictionDamper() : pipeline_(rig()) {}
  void push(double t_s, double table_mm, double force) {
    for (std::uint16_t c = 0; c < 2; ++c) {
      Record record;
      record.t_ns = std::llround(t_s * 1e9);
      record.value = c == 0 ? table_mm : force;
      record.channel = c;
      if (pipeline_.push(record) & kCompleted) keep();
    }
  }
  // Ends the recording. Gives the dwells that settled.
  std::vector<Dwell> settled() {
    if (pipeline_.finish() & kCompleted) keep();
    return dwells_;
  }
  [[nodiscard]] std::string conditions() const {
    return pipeline_.condition_reason(0) + "; " + pipeline_.condition_reason(1);
  }

 private:
  static Rig rig() {
    Rig rig;
    rig.boundary = Boundary::clamped;
    rig.excitation.frequency_hz = 1.0;
    rig.excitation.minimum = 1e-3;
    rig.excitation.search_low_hz = 0.98;
    rig.excitation.search_high_hz = 1.02;
    rig.excitation.harmonics = 5;
    rig.tolerance = 0.05;
    rig.channels.resize(2);
    rig.channels[0].name = "y0";
    rig.channels[0].si_per_unit = 1e-3;
    rig.channels[1].name = "load";
    rig.channels[1].measures = Quantity::force;
    rig.channels[1].at = kGround;
    return rig;
  }
  void keep() {
    if (std::isfinite(pipeline_.completed().settled_s)) dwells_.push_back(pipeline_.completed());
  }
  Pipeline pipeline_;
  std::vector<Dwell> dwells_;
};

bool says_far_from_linear(const Dwell& dwell) {
  return std::any_of(dwell.warnings.begin(), dwell.warnings.end(),
                     [](const Warning& w) { return w.what.find("far from linear") != std::string::npos; });
}

TEST(Pipeline, FindsTheHoldOfAFrictionDamperAndNothingOfItsRamps) {
  constexpr double kTravel = 25.58e-3, kStiffness = 2.3e5, kDamping = 2e4, kFriction = 6e3, kOmega = 2 * M_PI;
  const auto ramp = [](double t) { return std::min({t / 2, 1.0, std::max(0.0, 1 - (t - 4.95) / 2)}); };
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  FrictionDamper damper;
  const auto table = [&](double t) { return kTravel * ramp(t) * std::sin(kOmega * t); };
  for (int i = 0; i < 7 * 1024; ++i) {
    const double t = i / 1024.0, velocity = (table(t + 1e-6) - table(t - 1e-6)) / 2e-6;
    const double force = kStiffness * table(t) + kDamping * velocity +
                         kFriction * std::tanh(velocity / (0.01 * kOmega * kTravel)) + 20 * normal(random);
    damper.push(t, 1e3 * table(t) + 0.005 * normal(random), force);
  }
  const auto settled = damper.settled();
  ASSERT_EQ(settled.size(), 1u) << damper.conditions();
  EXPECT_GE(settled[0].settled_s, 1.95);  // its ramp's last step is within the noise
  EXPECT_LE(settled[0].end_s, 5.0);
  EXPECT_EQ(settled[0].ended_by, EndedBy::drive_changed);
  // Coulomb friction N at amplitude A acts as damping of 4N/(πωA) (den Hartog, Mechanical Vibrations).
  const double equivalent = kDamping + 4 * kFriction / (M_PI * kOmega * kTravel);
  EXPECT_NEAR(settled[0].elements[0].stiffness.value / kStiffness, 1.0, 0.01);
  EXPECT_NEAR(settled[0].elements[0].damping.value / equivalent, 1.0, 0.01);
  EXPECT_TRUE(says_far_from_linear(settled[0]));
}

// The same of a real one, where its recording lies beside the project: Coble and others, "Dataset-Friction-Damper-with-
// Backlash", 2022.
TEST(Pipeline, FindsTheHoldOfTheRealFrictionDamperAndNothingOfItsRamps) {
  std::ifstream file(DWELL_RECORDINGS "/friction-damper/1Hz-30lb-1in.csv");
  if (!file) GTEST_SKIP() << "the recording is not beside the project";
  FrictionDamper damper;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    double t = 0, y = 0, f = 0;
    char comma = 0;
    cells >> t >> comma >> y >> comma >> f;
    damper.push(t, y, f);
  }
  const auto settled = damper.settled();
  ASSERT_EQ(settled.size(), 1u) << damper.conditions();
  const Dwell& hold = settled[0];
  EXPECT_GE(hold.settled_s, 2.0);
  EXPECT_LE(hold.end_s, 4.95);
  EXPECT_EQ(hold.ended_by, EndedBy::drive_changed);  // the recording ends before the ramp does
  EXPECT_NEAR(hold.frequency_hz.value, 0.9999, 0.002);
  EXPECT_NEAR(std::abs(hold.phasors[0].Y), 25.58e-3, 0.1e-3);
  ASSERT_TRUE(hold.elements[0].identifiable);
  EXPECT_NEAR(hold.elements[0].stiffness.value / 2.337e5, 1.0, 0.02);
  EXPECT_NEAR(hold.elements[0].damping.value / 6.380e4, 1.0, 0.02);
  EXPECT_NEAR(hold.phasors[1].harmonics[1], 0.209, 0.01);
  EXPECT_TRUE(says_far_from_linear(hold));
}

}  // namespace
}  // namespace dwell
