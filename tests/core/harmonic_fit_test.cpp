#include "core/fit/harmonic_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "core/fit/blocks.hpp"

namespace dwell {
namespace {

constexpr double kPi = std::numbers::pi;

struct Reading {
  int channel;
  std::int64_t t_ns;
  double value;
};

// Feeds readings into quarter blocks of the period of `omega`, as the pipeline does.
void feed(Blocks& blocks, double omega, const std::vector<Reading>& readings) {
  const auto quarter = static_cast<std::int64_t>(std::llround(0.5e9 * kPi / omega));
  std::int64_t begin = 0;
  blocks.open(begin, begin + quarter, omega);
  for (const Reading& r : readings) {
    while (r.t_ns >= blocks.open_end_ns()) {
      blocks.close();
      begin += quarter;
      blocks.open(begin, begin + quarter, omega);
    }
    blocks.add(r.channel, r.t_ns, r.value);
  }
}

// The same least squares by QR on the samples themselves.
Eigen::VectorXd direct(const std::vector<Reading>& readings, int channel, int H, double omega, std::int64_t t_ref_ns) {
  std::vector<Reading> own;
  for (const Reading& r : readings)
    if (r.channel == channel) own.push_back(r);
  Eigen::MatrixXd X(own.size(), 2 * H + 1);
  Eigen::VectorXd s(own.size());
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const double theta = omega * 1e-9 * static_cast<double>(own[static_cast<std::size_t>(i)].t_ns - t_ref_ns);
    X(i, 0) = 1;
    for (int h = 1; h <= H; ++h) X(i, h) = std::sin(h * theta), X(i, H + h) = std::cos(h * theta);
    s(i) = own[static_cast<std::size_t>(i)].value;
  }
  return X.householderQr().solve(s);
}

std::vector<Reading> random_readings(std::mt19937_64& rng, int channels, double omega, double seconds, double rate,
                                     double missing) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  std::vector<Reading> out;
  for (double t = 0; t < seconds; t += (0.5 + uniform(rng)) / rate) {
    const auto t_ns = static_cast<std::int64_t>(t * 1e9);
    for (int c = 0; c < channels; ++c) {
      if (uniform(rng) < missing) continue;
      const double theta = omega * t + c;
      out.push_back({c, t_ns, 100.0 * c + 2 * std::sin(theta) + 0.3 * std::cos(2 * theta) + 0.01 * normal(rng)});
    }
  }
  return out;
}

TEST(HarmonicFit, EqualsADirectLeastSquaresSolutionWhateverIsMissingJoinedOrShared) {
  std::mt19937_64 rng(7);
  for (int trial = 0; trial < 60; ++trial) {
    const int H = 1 + trial % 8;
    const double omega = 2 * kPi * (1 + trial % 7), missing = trial % 3 == 0 ? 0.0 : 0.02 * (trial % 5);
    const auto readings = random_readings(rng, 4, omega, 6, 4.0 * (2 * H + 2) * omega / (2 * kPi), missing);
    Blocks blocks(4, H);
    for (int c = 0; c < 4; ++c) blocks.set_reference(c, 100.0 * c);
    feed(blocks, omega * (1 + 3e-4), readings);  // taken slightly off the frequency of the sum
    Totals totals(4, H);
    const int longest = blocks.block(0).quarters;
    const std::int64_t t_ref = 3'000'000'000;
    blocks.sum(0, blocks.count(), omega, t_ref, totals);
    blocks.add_open(totals);
    for (int c = 0; c < 4; ++c) {
      const HarmonicFit fit = fit_harmonics(totals, c, H, blocks.reference(c));
      ASSERT_TRUE(fit.usable);
      const Eigen::VectorXd truth = direct(readings, c, H, omega, t_ref);
      // What turning a quarter loses, (kδu)²/6, and a long block, (kδu)³/6, times the amplitude of 2
      // and what the other harmonics add.
      const double quarter = 3e-4 * kPi / 4 * 2 * H;
      const double left = 3 * (std::pow(quarter, 2) + std::pow(quarter * longest, 3)) / 6 + 1e-9;
      EXPECT_NEAR(fit.mean, truth(0), left + 1e-10 * 100 * c) << "trial " << trial;
      for (int h = 1; h <= H; ++h) {
        EXPECT_NEAR(fit.X[static_cast<std::size_t>(h - 1)].real(), truth(h), left) << "trial " << trial << " h " << h;
        EXPECT_NEAR(fit.X[static_cast<std::size_t>(h - 1)].imag(), truth(H + h), left)
            << "trial " << trial << " h " << h;
      }
    }
  }
}

TEST(HarmonicFit, ItsScoreLeadsToTheFrequencyOfTheMotion) {
  const double omega = 2 * kPi * 5, wrong = omega * 1.002;
  std::vector<Reading> readings;
  for (int i = 0; i < 2000; ++i)
    readings.push_back(
        {0, i * 2'000'000LL, 3 * std::sin(omega * i * 0.002 + 0.4) + 0.2 * std::sin(2 * omega * i * 0.002)});
  Blocks blocks(1, 3);
  feed(blocks, wrong, readings);
  Totals totals(1, 3);
  double now = wrong;
  for (int step = 0; step < 6; ++step) {
    blocks.sum(0, blocks.count(), now, 2'000'000'000, totals);
    blocks.add_open(totals);
    const HarmonicFit fit = fit_harmonics(totals, 0, 3, 0.0);
    now += fit.score / fit.information;
  }
  // Blocks taken off by δ leave about 0.06 (P/T)² δ, P one period of the T = 20: 3e-7.
  EXPECT_NEAR(now / omega, 1.0, 3e-7);
}

TEST(HarmonicFit, ItsCovarianceIsTheCramerRaoBound) {
  // 400 repetitions: the sample variance of p_1 has a relative standard deviation of √(2/400) = 7 %; 4 of them.
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  double squares = 0, stated = 0;
  const int kRepetitions = 400, kSamples = 500;
  for (int repetition = 0; repetition < kRepetitions; ++repetition) {
    std::vector<Reading> readings;
    for (int i = 0; i < kSamples; ++i)
      readings.push_back({0, i * 10'000'000LL, std::sin(2 * kPi * 2 * i * 0.01) + 0.1 * normal(rng)});
    Blocks blocks(1, 2);
    feed(blocks, 2 * kPi * 2, readings);
    Totals totals(1, 2);
    blocks.sum(0, blocks.count(), 2 * kPi * 2, 0, totals);
    blocks.add_open(totals);
    const HarmonicFit fit = fit_harmonics(totals, 0, 2, 0.0);
    squares += std::pow(fit.X[0].real() - 1.0, 2) / kRepetitions;
    stated += fit.covariance(0, 0) / kRepetitions;
  }
  const double bound = 2 * 0.01 / kSamples;
  EXPECT_NEAR(squares / bound, 1.0, 0.28);
  EXPECT_NEAR(stated / bound, 1.0, 0.02);
}

TEST(HarmonicFit, TooFewOrTooCloseSamplesAreNoFit) {
  Blocks blocks(1, 3);
  std::vector<Reading> readings;
  for (int i = 0; i < 50; ++i) readings.push_back({0, i * 1'000'000LL, std::sin(0.001 * i)});  // 50 ms of a 1 s period
  feed(blocks, 2 * kPi, readings);
  Totals totals(1, 3);
  blocks.sum(0, blocks.count(), 2 * kPi, 0, totals);
  blocks.add_open(totals);
  const HarmonicFit fit = fit_harmonics(totals, 0, 3, 0.0);
  EXPECT_FALSE(fit.usable);
  EXPECT_TRUE(std::isnan(fit.mean));
}

TEST(HarmonicFit, TellsTheSlopeOfAPhasorThatChanges) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  const double omega = 2 * kPi * 4;
  const std::complex<double> X{2.0, 0.5}, slope{0.03, -0.02};
  for (const double seconds : {0.45, 1.1, 10.0}) {
    std::vector<Reading> readings;
    for (double t = 0; t < seconds; t += 1.0 / 400)
      readings.push_back(
          {0, std::llround(t * 1e9),
           ((X + slope * (t - seconds / 2)) * std::polar(1.0, omega * (t - seconds / 2))).imag() + 1e-4 * normal(rng)});
    Blocks blocks(1, 3);
    feed(blocks, omega, readings);
    Totals totals(1, 3);
    blocks.sum(0, blocks.count(), omega, std::llround(seconds / 2 * 1e9), totals);
    blocks.add_open(totals);
    const HarmonicFit fit = fit_harmonics(totals, 0, 3, 0.0);
    const PhasorSlope found = HarmonicFits(totals, 3).slope(0, fit, 0.0);
    EXPECT_TRUE(found.shows()) << seconds;
    EXPECT_LT(std::abs(found.value - slope), 0.35 * std::abs(slope) * (seconds < 1 ? 1.0 : 0.3)) << seconds;
  }
}

}  // namespace
}  // namespace dwell
