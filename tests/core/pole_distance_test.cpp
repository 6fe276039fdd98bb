// The distance of two poles, as a fit's covariance has it and as the likelihood has it.
#include "core/transient/pole_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace dwell {
namespace {

// Samples of one decaying oscillation, and what single poles leave of them.
struct Oscillation {
  Complex pole;
  double seen_s;
  int samples;
  std::vector<Complex> y;

  Oscillation(Complex pole_, double seen_s_, int samples_) : pole(pole_), seen_s(seen_s_), samples(samples_) {
    for (int i = 0; i < samples; ++i) y.push_back(std::exp(pole * at(i)));
  }
  [[nodiscard]] double at(int i) const { return seen_s * (i + 0.5) / samples; }
  // Σ|y - a e^{λt}|² with the best a.
  [[nodiscard]] double misfit(Complex other) const {
    Complex onto{};
    double own = 0.0, whole = 0.0;
    for (int i = 0; i < samples; ++i) {
      const Complex e = std::exp(other * at(i));
      onto += std::conj(e) * y[static_cast<std::size_t>(i)];
      own += std::norm(e);
      whole += std::norm(y[static_cast<std::size_t>(i)]);
    }
    return whole - std::norm(onto) / own;
  }
  // Gauss-Newton from `pole` on, amplitude eliminated. Sets the curvature of the misfit by the pole, halved.
  Complex fitted(double& curvature) const {
    Complex now = pole;
    for (int pass = 0; pass < 20; ++pass) {
      double own = 0.0, mean = 0.0, square = 0.0;
      Complex onto{}, slope{};
      for (int i = 0; i < samples; ++i) {
        const Complex e = std::exp(now * at(i)), z = std::conj(e) * y[static_cast<std::size_t>(i)];
        const double w = std::norm(e);
        own += w, mean += w * at(i), square += w * at(i) * at(i);
        onto += z, slope += at(i) * z;
      }
      const Complex a = onto / own;
      mean /= own;
      curvature = std::norm(a) * (square - own * mean * mean);
      const Complex step = std::conj(a) * (slope - mean * onto) / curvature;
      now += step;
      if (std::abs(step) < 1e-9 * std::abs(now)) break;
    }
    return now;
  }
};

TEST(PoleDistance, IsThatOfTheLikelihoodOfOneOscillation) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    const Complex seen{-0.1 - 5 * unit(rng), 20 + 40 * unit(rng)};
    const double seen_s = (0.2 + 6 * unit(rng)) / -seen.real();
    const double scale = std::max(-seen.real(), 1 / seen_s);
    const Complex other{seen.real() * (0.4 + 1.2 * unit(rng)), seen.imag() + 2 * scale * (unit(rng) - 0.5)};
    const Oscillation oscillation(seen, seen_s, 4000);
    // The parabola's height at `other`, from the misfit near `seen`.
    const double near = 1e-3;
    const double parabola = oscillation.misfit(seen + near * (other - seen)) / (near * near);
    const double overstated = parabola / oscillation.misfit(other);
    // The parabola is taken at a thousandth of the way: it is good to some thousandths.
    EXPECT_NEAR(overstated_distance(seen, other, seen_s), std::max(1.0, overstated), 0.01 * std::max(1.0, overstated))
        << seen << " " << other << " " << seen_s;
  }
}

// Pole errors of a fifth of the decay rate: beyond what normal errors exceed once in 10 000.
TEST(PoleDistance, LetsAWeakOscillationContradictItsOwnPoleNoOftenerThanByChance) {
  constexpr int kDraws = 40000;
  constexpr double kOnceIn10000 = 18.4;  // χ² of two degrees of freedom
  const Complex truth{-5.0, 60.0};
  const double seen_s = 0.8;
  const Oscillation clean(truth, seen_s, 60);
  double curvature = 0.0;
  clean.fitted(curvature);
  const double sigma = 0.2 * 5.0 * std::sqrt(0.5 * curvature);  // then the pole's u is a fifth of the decay, as a whole
  std::mt19937_64 rng(2);
  std::normal_distribution<double> noise(0.0, sigma);
  int parabola = 0, likelihood = 0;
  for (int i = 0; i < kDraws; ++i) {
    Oscillation noisy = clean;
    for (Complex& y : noisy.y) y += Complex{noise(rng), noise(rng)};
    const Complex pole = noisy.fitted(curvature);
    const double chi2 = std::norm(pole - truth) * curvature / (sigma * sigma);
    parabola += chi2 > kOnceIn10000;
    likelihood += chi2 / overstated_distance(pole, truth, seen_s) > kOnceIn10000;
  }
  // By chance 4, with a standard deviation of 2.
  EXPECT_GE(parabola, 20) << "the parabola alone would do";  // eight standard deviations
  EXPECT_LE(likelihood, 10);                                 // three
}

TEST(PoleDistance, IsNotOverstatedNearThePoleNorWhereNothingDecays) {
  EXPECT_EQ(overstated_distance({-2.0, 30.0}, {-2.0, 30.0}, 1.0), 1.0);
  EXPECT_EQ(overstated_distance({-2.0, 30.0}, {0.1, 30.0}, 1.0), 1.0);
  EXPECT_EQ(overstated_distance({-2.0, 30.0}, {-2.0, 33.0}, 0.0), 1.0);
}

}  // namespace
}  // namespace dwell
