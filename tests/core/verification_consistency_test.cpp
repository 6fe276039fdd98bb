#include "core/verify/verification_consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kRows = 2000, kDraws = 64;

MatrixXd white(Index columns, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(kRows, columns, [&] { return normal(rng); });
}

// A source that swings slowly, with a standard deviation of three times the noise.
MatrixXd slow_source() {
  MatrixXd out(kRows, 1);
  for (Index i = 0; i < kRows; ++i) out(i, 0) = 3 * std::sin(0.01 * static_cast<double>(i));
  return out;
}

MatrixXd draws(const SourceFit& fit) {
  std::mt19937_64 rng(7);
  std::normal_distribution<double> normal;
  const MatrixXd z = MatrixXd::NullaryExpr(fit.sources().cols(), kDraws, [&] { return normal(rng); });
  return white(kDraws, 11) + fit.sources() * z;
}

double p_of(const SourceFit& fit, const VectorXd& error) {
  return consistency_of(fit, error, {kRows / 2, kRows}, draws(fit), 1e6).p();
}

TEST(VerificationConsistency, RaisesFewFalseAlarms) {
  const SourceFit fit(slow_source());
  int alarms = 0;
  for (std::uint64_t seed = 100; seed < 400; ++seed)
    if (p_of(fit, white(1, seed) + 1.2 * slow_source()) < kLeastP) ++alarms;
  EXPECT_LE(alarms, 9);  // three are expected of 300; nine or more come once in 300 times
}

TEST(VerificationConsistency, LetsASourceExplainWhatItsUncertaintyAllows) {
  const SourceFit fit(slow_source());
  EXPECT_GT(p_of(fit, white(1, 1) + 2.0 * slow_source()), kLeastP);
  EXPECT_LT(p_of(fit, white(1, 1) + 40.0 * slow_source()), kLeastP);
}

TEST(VerificationConsistency, SeesACourseInTimeBelowTheNoise) {
  const SourceFit fit(MatrixXd::Zero(kRows, 1));
  VectorXd course(kRows);
  for (Index i = 0; i < kRows; ++i) course(i) = 0.5 * std::sin(0.05 * static_cast<double>(i));
  EXPECT_LT(p_of(fit, white(1, 3) + course), kLeastP);
}

TEST(VerificationConsistency, SeesNoiseThatIsTooLarge) {
  const SourceFit fit(MatrixXd::Zero(kRows, 1));
  const Consistency seen = consistency_of(fit, 1.1 * white(1, 3), {kRows}, draws(fit), 1e6);
  EXPECT_LT(seen.p(), kLeastP);
  EXPECT_NEAR(seen.chi2, 1.21, 0.08);
  // Known from few readings the noise may well be larger.
  EXPECT_GT(consistency_of(fit, 1.1 * white(1, 3), {kRows}, draws(fit), 60).p(), kLeastP);
}

}  // namespace
}  // namespace dwell
