#include "core/transient/modal_regressors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

constexpr double kRegressedOmega = 2 * M_PI * 5.0;
const std::vector<Complex> kTwoPoles{{-0.5, 33.0}, {-2.0, 60.0}};

// The reading of a motion whose linear parameters are all 1, so that derivatives can be taken by differences.
double reading_at(double omega, const std::vector<Complex>& poles, std::int64_t t_ns) {
  ModalRegressors regressors(2, 4);
  regressors.restart(omega, 0.0, 0, poles);
  return regressors.at(t_ns).head(regressors.layout().linear()).sum();
}

TEST(ModalRegressors, AreThoseOfTheMotion) {
  ModalRegressors regressors(2, 4);
  regressors.restart(kRegressedOmega, 0.0, 0, kTwoPoles);
  const ModalLayout& layout = regressors.layout();
  EXPECT_EQ(layout.linear(), 5 + 4);
  EXPECT_EQ(layout.all(), 5 + 4 + 4 + 2);
  const double u = 0.37;
  const Eigen::VectorXd& x = regressors.at(370'000'000);
  EXPECT_EQ(x(0), 1.0);
  for (int h = 1; h <= 2; ++h) {
    EXPECT_NEAR(x(layout.sine(h)), std::sin(h * kRegressedOmega * u), 1e-12);
    EXPECT_NEAR(x(layout.cosine(h)), std::cos(h * kRegressedOmega * u), 1e-12);
  }
  for (Eigen::Index m = 0; m < 2; ++m) {
    // Re (a exp λu) of a = 1 and of a = j.
    const Complex e = std::exp(kTwoPoles[static_cast<std::size_t>(m)] * u);
    EXPECT_NEAR(x(layout.amplitude(m)), e.real(), 1e-12);
    EXPECT_NEAR(x(layout.amplitude(m) + 1), -e.imag(), 1e-12);
  }
}

TEST(ModalRegressors, TheDerivativesAreThoseByRelativeChanges) {
  ModalRegressors regressors(2, 4);
  regressors.restart(kRegressedOmega, 0.0, 0, kTwoPoles);
  const ModalLayout& layout = regressors.layout();
  const std::int64_t t_ns = 370'000'000;
  const Eigen::VectorXd x = regressors.at(t_ns);
  constexpr double kSmall = 1e-6;
  for (Eigen::Index m = 0; m < 2; ++m) {
    std::vector<Complex> more = kTwoPoles, less = kTwoPoles;
    const auto i = static_cast<std::size_t>(m);
    more[i] += kSmall * std::abs(kTwoPoles[i]);
    less[i] -= kSmall * std::abs(kTwoPoles[i]);
    const double slope =
        (reading_at(kRegressedOmega, more, t_ns) - reading_at(kRegressedOmega, less, t_ns)) / (2 * kSmall);
    EXPECT_NEAR(x.segment<2>(layout.by_pole(m)).sum(), slope, 1e-6 * std::abs(slope)) << m;
  }
  // By ω: ωu sin and ωu cos of the fundamental, whatever the coefficients.
  EXPECT_NEAR(x(layout.by_omega()), kRegressedOmega * 0.37 * x(layout.sine(1)), 1e-12);
  EXPECT_NEAR(x(layout.by_omega() + 1), kRegressedOmega * 0.37 * x(layout.cosine(1)), 1e-12);
}

TEST(ModalRegressors, AFadedModeIsNothingFromThenOnUntilTheNextRestart) {
  ModalRegressors regressors(1, 2);
  regressors.restart(kRegressedOmega, 0.0, 0, kTwoPoles);
  regressors.fade(0, 500'000'000);
  EXPECT_EQ(regressors.faded_ns(0), 500'000'000);
  const ModalLayout& layout = regressors.layout();
  EXPECT_NE(regressors.at(499'000'000)(layout.amplitude(0)), 0.0);
  const Eigen::VectorXd& x = regressors.at(500'000'000);
  EXPECT_EQ(x.segment<2>(layout.amplitude(0)).norm(), 0.0);
  EXPECT_EQ(x.segment<2>(layout.by_pole(0)).norm(), 0.0);
  EXPECT_NE(x(layout.amplitude(1)), 0.0);
  regressors.restart(kRegressedOmega, 0.0, 0, kTwoPoles);
  EXPECT_NE(regressors.at(600'000'000)(layout.amplitude(0)), 0.0);
}

}  // namespace
}  // namespace dwell
