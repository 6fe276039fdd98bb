// What the study judges by: the bound against scatter seen, the oracle and the drawn rigs against what the study claims
// to draw.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/study/bound.hpp"
#include "tests/study/case.hpp"
#include "tests/study/figures.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

TEST(StudyBound, IsTheScatterOfWhatNoisyPhasorsGive) {
  for (const int index : {1, 4, 7}) {
    const Case about = draw(Population::white, 1, index);
    const double seconds = 80 * about.period_s();
    const std::vector<ElementBound> bounds = bounds_of(about, seconds);
    Draws draws(7);
    std::vector<double> squares(2 * bounds.size());
    constexpr int kDraws = 4000;
    for (int i = 0; i < kDraws; ++i) {
      std::vector<Complex> X;
      for (int c = 0; c < about.channels(); ++c) {
        const Line& line = about.lines[static_cast<std::size_t>(c)];
        const double sigma = line.noise() * std::sqrt(2 / (line.rate_hz * seconds));
        const double p = sigma * draws.normal(), q = sigma * draws.normal();
        X.push_back(about.motion->phasor(c, 1) + Complex{p, q});
      }
      const std::vector<Complex> Z = stiffness_of(about, kTwoPi * about.frequency_hz, X);
      for (std::size_t e = 0; e < Z.size(); ++e) {
        squares[2 * e] += std::pow(Z[e].real() - bounds[e].Z.real(), 2);
        squares[2 * e + 1] += std::pow(Z[e].imag() - bounds[e].Z.imag(), 2);
      }
    }
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const ElementBound& bound = bounds[i / 2];
      if (std::abs(bound.Z) < 30 * bound.sigma_Z) continue;  // first order is not enough
      EXPECT_NEAR(std::sqrt(squares[i] / kDraws), bound.sigma_Z, 0.05 * bound.sigma_Z)
          << "rig " << index << ", element " << i / 2 + 1;
    }
  }
}

TEST(StudyBound, HoldsTheTrueStiffnessExactlyWithoutNoise) {
  const Case about = draw(Population::white, 1, 2);
  std::vector<Complex> X;
  for (int c = 0; c < about.channels(); ++c) X.push_back(about.motion->phasor(c, 1));
  const std::vector<Complex> Z = stiffness_of(about, kTwoPi * about.frequency_hz, X);
  for (std::size_t e = 0; e < Z.size(); ++e) {
    EXPECT_NEAR(Z[e].real() / about.chain.stiffness[e], 1, 1e-6);
    EXPECT_NEAR(Z[e].imag() / (kTwoPi * about.frequency_hz * about.chain.damping[e]), 1, 1e-4);
  }
}

TEST(StudyDraws, CoverMassesBoundariesDampingAndDrivesAsClaimed) {
  std::set<int> masses;
  std::set<Boundary> boundaries;
  double lightest = 1, heaviest = 0, slowest = 100, fastest = 0, fewest = 1000, most = 0;
  int beating = 0;
  for (int index = 0; index < 400; ++index) {
    const Case about = draw(Population::white, 1, index);
    masses.insert(about.chain.mass_count());
    boundaries.insert(about.chain.boundary);
    for (const Complex& lambda : natural_values(about.chain)) {
      const double ratio = -lambda.real() / std::abs(lambda);
      lightest = std::min(lightest, ratio);
      heaviest = std::max(heaviest, ratio);
      beating += lambda.imag() > 0 && std::abs(lambda.imag() / (kTwoPi * about.frequency_hz) - 1) < 0.01;
    }
    slowest = std::min(slowest, about.frequency_hz);
    fastest = std::max(fastest, about.frequency_hz);
    for (int c = 0; c < about.channels(); ++c) {
      fewest = std::min(fewest, about.samples_per_period(c));
      most = std::max(most, about.samples_per_period(c));
    }
  }
  EXPECT_EQ(masses, (std::set<int>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(boundaries.size(), 2U);
  EXPECT_GT(lightest, 0.0029);
  EXPECT_LT(lightest, 0.004);
  EXPECT_GT(heaviest, 0.18);
  EXPECT_LT(heaviest, 0.201);
  EXPECT_GE(slowest, 2);
  EXPECT_LE(fastest, 40);
  EXPECT_GE(fewest, 10);
  EXPECT_LE(most, 200);
  EXPECT_GT(most, 150);
  EXPECT_GT(beating, 30);
}

// The recording of a rig with type B errors, its stamps, scales and all, against what its rig file makes of them.
TEST(StudyRecording, CarriesTheErrorsThatItWasDrawn) {
  const Case about = draw(Population::type_b, 1, 3);
  const Line& line = about.lines[1];
  const double t_s = instant_s(about, 1, 100);
  EXPECT_NEAR(stamp_s(about, 1, t_s), t_s * (1 + about.clock_error) + line.shift_s, 1e-12);
  EXPECT_LE(std::abs(line.shift_s), 1e-9 * about.half_ns[1] + 1e-9);
  EXPECT_NE(about.sensors[1].gain, 1.0);
  EXPECT_NE(about.rig.masses[0], about.chain.masses[0]);
  double squares = 0.0;
  constexpr int kRigs = 500;
  for (int index = 0; index < kRigs; ++index) {
    const Case drawn = draw(Population::type_b, 1, index);
    squares += std::pow((drawn.sensors[0].gain - 1) / drawn.rig.channels[0].scale_u, 2) / kRigs;
  }
  EXPECT_NEAR(squares, 1, 0.2);
}

TEST(StudyFigures, CoverageCountsBothCoefficientsAndLeavesInseparableHumOut) {
  Outcome inside;
  inside.completed = true;
  inside.elements.resize(1);
  inside.elements[0].reported = true;
  Outcome half = inside, excluded = inside;
  half.elements[0].r_U95 = -1.5;
  excluded.elements[0].c_U95 = excluded.elements[0].r_U95 = 9;
  excluded.hum_inseparable = excluded.hum_warned = true;
  const Row row = coverage_row({inside, half, excluded}, Population::hum, 0);
  EXPECT_EQ(row.reached, "75.0 %");
  EXPECT_EQ(row.count, 2);
  EXPECT_FALSE(row.met);
}

TEST(StudyFigures, ADwellThatNeverSettledIsLateAndNotEarly) {
  Outcome never, good;
  good.settled = true;
  good.period_s = never.period_s = 0.1;
  good.verdict_s = 0.3;
  const std::vector<Row> rows = settling_rows({never, good}, 0);
  EXPECT_EQ(rows[0].reached, "0.00 %");
  EXPECT_EQ(rows[2].reached, "inf");
  EXPECT_FALSE(rows[2].met);
}

TEST(StudyDraws, RampsRiseHoldAndFall) {
  Ramps ramps{1, 2, 5, 7};
  EXPECT_EQ(ramps.factor(0.5), 0);
  EXPECT_EQ(ramps.factor(1.5), 0.5);
  EXPECT_EQ(ramps.factor(3), 1);
  EXPECT_EQ(ramps.factor(6), 0.5);
  EXPECT_EQ(ramps.factor(8), 0);
  EXPECT_EQ(Ramps{}.factor(1e9), 1);
}

}  // namespace
}  // namespace dwell::study
