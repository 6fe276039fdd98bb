// The population `disturbed`: its simulation against closed forms, what it draws, and what it takes for a warning.
#include "tests/study/disturbed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/base/angle.hpp"
#include "tests/study/bound.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

constexpr Complex kJ{0.0, 1.0};

std::vector<Sensor> displacements_and_force(int masses) {
  std::vector<Sensor> sensors;
  for (int k = 0; k <= masses; ++k) {
    Sensor sensor;
    sensor.at = k;
    sensors.push_back(sensor);
  }
  Sensor force;
  force.measures = Quantity::force;
  force.at = kGround;
  sensors.push_back(force);
  return sensors;
}

const Chain& two_masses() {
  static const Chain chain{Boundary::clamped, {8, 5}, {9000, 6000, 7000}, {40, 25, 30}};
  return chain;
}

TEST(StudyMotion, ASideSpringFromTheFirstMassToTheTableIsPartOfElementOne) {
  Chain stiffer = two_masses();
  stiffer.stiffness[0] += 500;
  stiffer.damping[0] += 3;
  const std::vector<Sensor> sensors = displacements_and_force(2);
  Motion beside(two_masses(), sensors, {{1, 0, 500, 3}}), within(stiffer, sensors);
  for (Motion* motion : {&beside, &within}) motion->drive(0.0, {4.0, {0.002, 0.0001 * kJ}});
  for (int i = 0; i < 200; ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(beside.reading(c, 0.01 * i), within.reading(c, 0.01 * i), 1e-12);
}

TEST(StudyMotion, ATableWhoseAmplitudeSwingsReadsAsTheProductOfBoth) {
  Motion motion(two_masses(), displacements_and_force(2));
  const double a = 0.1, f = 4.0, hz = 0.3;
  const Complex half = 0.002 * a / 2;
  motion.drive(0.0, {f, {0.002}, {{f + hz, half * -kJ}, {f - hz, half * kJ}}});
  for (int i = 0; i < 300; ++i) {
    const double t_s = 0.013 * i;
    EXPECT_NEAR(motion.reading(0, t_s), 0.002 * (1 + a * std::sin(kTwoPi * hz * t_s)) * std::sin(kTwoPi * f * t_s),
                1e-15);
  }
}

TEST(StudyCourse, WithoutFrictionItIsTheLinearMotion) {
  const std::vector<Sensor> sensors = displacements_and_force(2);
  const TableMotion table{4.0, {0.002, 0.0001 * kJ}};
  Motion motion(two_masses(), sensors);
  motion.drive(0.0, table);
  const Course course(two_masses(), sensors, {}, table, 3.0);
  for (int i = 10; i < 290; ++i)
    for (int c = 0; c < 4; ++c)
      EXPECT_NEAR(course.reading(c, 0.01 * i), motion.reading(c, 0.01 * i), 1e-5 * std::abs(motion.phasor(c, 1)));
}

// F = c y + r y' + F_c sign(y'): its fundamental is that of r + 4 F_c / (π ω a) (docs/method.md, weak nonlinearity).
TEST(StudyCourse, FrictionOfAnElementWithoutMassesIsItsEquivalentDamping) {
  const Chain chain{Boundary::clamped, {}, {2e4}, {40}};
  const double f = 4.0, a = 0.002, friction = 3.0, cubic = 1e9, omega = kTwoPi * f;
  const Course course(chain, displacements_and_force(0), {1, friction, cubic}, {f, {a}}, 2.0);
  Complex F = 0.0;
  constexpr int kSamples = 4000;  // of four periods
  for (int i = 0; i < kSamples; ++i) {
    const double t_s = 0.25 + (i + 0.5) / kSamples;
    F += 2.0 * kJ * course.reading(1, t_s) * std::polar(1.0, -omega * t_s) / double{kSamples};
  }
  const Complex Z = F / a;
  EXPECT_NEAR(Z.real(), 2e4 + 0.75 * cubic * a * a, 2);
  EXPECT_NEAR(Z.imag() / omega, 40 + 4 * friction / (std::numbers::pi * omega * a), 0.2);
}

TEST(StudyDisturbed, EveryKindIsDrawnAsOftenAndSomeTogether) {
  std::map<Kind, int> drawn;
  int both = 0;
  for (int index = 0; index < 10 * kKinds; ++index) {
    const Case about = draw(Population::disturbed, 1, index);
    ASSERT_FALSE(about.disturbances.empty());
    both += about.disturbances.size() > 1;
    for (const Disturbance& disturbance : about.disturbances) ++drawn[disturbance.kind];
  }
  EXPECT_EQ(drawn.size(), static_cast<std::size_t>(kKinds));
  EXPECT_GT(both, 10);
  EXPECT_LT(both, 100);
}

TEST(StudyDisturbed, StrengthsReachFromHarmlessToGross) {
  std::map<Kind, std::set<bool>> harmless;
  for (int index = 0; index < 8 * kKinds; ++index) {
    const Case about = draw(Population::disturbed, 1, index);
    const Kind kind = about.disturbances[0].kind;
    if (is_of_model(kind)) continue;
    const double seconds = about.hold_periods * about.period_s();
    harmless[kind].insert(moved_by(about, about.change_s + 5 * about.motion->time_constant_s(), seconds).harmless());
  }
  // Not a slow refresh: half of its period late on average, it never is harmless.
  for (const Kind kind : {Kind::clip_one, Kind::zeros_one, Kind::repeats_one, Kind::folded, Kind::stations,
                          Kind::fixed_off, Kind::hunting})
    EXPECT_EQ(harmless[kind].size(), 2U) << name_of(kind);
}

TEST(StudyDisturbed, AReadingRefreshedSlowlyIsTheOneOfTheLastRefresh) {
  Case about = draw(Population::white, 1, 3);
  about.mishaps.resize(about.lines.size());
  about.mishaps[1].refresh_s = 3 / about.lines[1].rate_hz;
  std::set<double> values;
  for (int i = 0; i < 300; ++i) values.insert(reading(about, 1, i, instant_s(about, 1, i)));
  EXPECT_NEAR(static_cast<double>(values.size()), 100, 2);
}

TEST(StudyDisturbed, RepeatsOfWholeScansBefallAllChannelsAtOnce) {
  Case about = draw(Population::disturbed, 1, static_cast<int>(Kind::repeats_all));
  int together = 0, alone = 0;
  const auto repeats = [&](int c, int i) {
    return reading(about, c, i, instant_s(about, c, i)) == reading(about, c, i - 1, instant_s(about, c, i - 1));
  };
  about.mishaps[0].repeats = about.mishaps[1].repeats = 0.1;
  for (Line& line : about.lines) line.step = 0.0;
  for (int i = 1; i < 2000; ++i) {
    together += repeats(0, i) && repeats(1, i);
    alone += repeats(0, i) != repeats(1, i);
  }
  EXPECT_GT(together, 100);
  EXPECT_EQ(alone, 0);
}

// One mode A exp(λt) seen until it has gone, its amplitude unknown: σ(Re λ) = σ(Im λ) = 4 σ α^(3/2) / (A √rate), α its
// decay rate (the information is A² rate / (16 σ² α³)).
TEST(StudyDisturbed, WhatATransientTellsOfAPoleIsTheBoundInClosedForm) {
  Case about;
  about.frequency_hz = 2.0;
  about.chain = {Boundary::free, {10}, {10 * std::pow(kTwoPi * 9, 2)}, {2 * 0.02 * 10 * kTwoPi * 9}};
  about.rig.boundary = Boundary::free;
  about.rig.masses = about.chain.masses;
  about.rig.excitation.harmonics = 1;
  about.sensors = {{Quantity::displacement, 0, {}, 1.0, 0.0, {}}, {Quantity::displacement, 1, {}, 1.0, 0.0, {}}};
  about.lines.assign(2, Line{});
  for (Line& line : about.lines) line.rate_hz = 400, line.sigma = 1e-6;
  about.motion = std::make_shared<Motion>(about.chain, about.sensors);
  about.motion->drive(0.0, {2.0, {1e-3}}, MassState{{0.0}, {0.05}});
  const Motion::Swing swing = about.motion->swings(1)[0];
  const double alpha = -swing.lambda.real();
  const double expected = 4 * 1e-6 * std::pow(alpha, 1.5) / (std::abs(swing.weight) * std::sqrt(400.0));
  const std::vector<Complex> sigma = resolved_poles(about, 20 / alpha);
  ASSERT_EQ(sigma.size(), 1U);
  EXPECT_NEAR(sigma[0].real(), expected, 0.05 * expected);
  EXPECT_NEAR(sigma[0].imag(), expected, 0.05 * expected);
}

TEST(StudyDisturbed, ASwappedPairShowsInThePolesAndAScaleOfAllDoesNot) {
  Case about;
  for (int index = static_cast<int>(Kind::mass_off);; index += kKinds) {
    about = draw(Population::disturbed, 1, index);
    if (about.chain.mass_count() == 2 && about.disturbances.size() == 1) break;
  }
  const double from_s = about.change_s + 5 * about.motion->time_constant_s(), seconds = 50 * about.period_s();
  const std::vector<double> stated = about.rig.masses;
  about.rig.masses = about.chain.masses;
  for (double& mass : about.rig.masses) mass *= 1.1;  // all alike: no pole of a free chain moves
  if (about.chain.boundary == Boundary::free) {
    EXPECT_LT(moved_by(about, from_s, seconds).shows, 0.1);
  }
  about.rig.masses = about.chain.masses;
  std::swap(about.rig.masses[0], about.rig.masses[1]);
  EXPECT_GT(moved_by(about, from_s, seconds).shows, kShows);
}

TEST(StudyDisturbed, AWarningCountsThatNamesTheChannelAndTheCause) {
  const Case about = draw(Population::disturbed, 1, static_cast<int>(Kind::clip_one));
  const Disturbance clipped{Kind::clip_one, "", {1}, {}};
  EXPECT_TRUE(names(about, clipped, "y1 is clipped at 0.9 of its amplitude: 12 % of its readings are equal"));
  EXPECT_FALSE(names(about, clipped, "y10 is clipped"));
  EXPECT_FALSE(names(about, clipped, "a channel is clipped"));
  EXPECT_FALSE(names(about, clipped, "y1 is not steady: its ratio to the table varies by 9.1 times its noise"));
  const Disturbance late{Kind::late, "", {1}, {1, 2}};
  EXPECT_TRUE(names(about, late, "elements 1 and 2: the natural frequency of 4.1 Hz contradicts the transient's 4.0"));
  EXPECT_TRUE(names(about, late,
                    "mode at 5.3 Hz: the transient shows 5.27 Hz; the identified chain (elements 1 … 2) has 5.32"));
  EXPECT_FALSE(names(about, late, "mode at 5.3 Hz: the transient shows 5.27 Hz; the identified chain has 5.32 Hz"));
  EXPECT_FALSE(names(about, late, "the model may be wrong"));
  const std::string term = "the readings are better explained with a mass 1 of 26.96 ± 0.25 kg instead of 27.62 kg";
  EXPECT_TRUE(names(about, {Kind::mass_off, "", {}, {1, 2}}, term));
  EXPECT_FALSE(names(about, clipped, term));
  const Disturbance hunting{Kind::hunting, "", {0}, {1, 2}}, fixed{Kind::fixed_off, "", {}, {1, 2}},
      stations{Kind::stations, "", {1}, {1, 2}};
  EXPECT_TRUE(names(about, hunting, "the drive is not steady: its amplitude changes by 0.3 % in a second"));
  EXPECT_FALSE(names(about, hunting, "element 1 is not linear: its r is an equivalent damping at this amplitude"));
  EXPECT_TRUE(names(about, fixed, "the drive is at 4.0002 Hz, the rig file says fixed at 4.0000 ± 0.0001 Hz"));
  EXPECT_FALSE(names(about, fixed, "mode at 4.77 Hz: it is excited more than by the drive at 4 Hz"));
  EXPECT_FALSE(names(about, stations, "the residuals of y1 are correlated"));
  EXPECT_TRUE(blames(about, "y1 is refreshed every 3 polls"));
  EXPECT_TRUE(blameless({WarningKind::hum, "hum of 50 Hz, if there is any, cannot be told from harmonic 1 in y1"}));
  EXPECT_TRUE(blameless({WarningKind::folded_harmonic, "harmonic 9 of the drive, if there is any, folds"}));
  EXPECT_FALSE(blameless({WarningKind::readings, "y1 is refreshed every 3 polls"}));
}

}  // namespace
}  // namespace dwell::study
