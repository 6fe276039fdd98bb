// The regressors of the modal fit at an instant.
#include "core/transient/modal_regressors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

constexpr double kTurning = 2 * M_PI * 5.0;
const std::vector<Complex> kTwoModes{{-0.5, 33.0}, {-2.0, 60.0}};
constexpr std::int64_t kStep_ns = 2'500'000;

TEST(ModalRegressors, AreConstantHarmonicsModesAndTheirDerivatives) {
  ModalRegressors regressors(2, 4);
  regressors.restart(kTurning, 0.0, 1000, kTwoModes);
  EXPECT_EQ(regressors.steady(), 5);
  EXPECT_EQ(regressors.modal(), 4);
  EXPECT_EQ(regressors.slopes(), 6);
  const double u = 0.3;
  const Eigen::VectorXd& x = regressors.at(1000 + 300'000'000);
  EXPECT_EQ(x(0), 1.0);
  EXPECT_NEAR(x(1), std::sin(kTurning * u), 1e-12);
  EXPECT_NEAR(x(2), std::sin(2 * kTurning * u), 1e-12);
  EXPECT_NEAR(x(4), std::cos(2 * kTurning * u), 1e-12);
  const Complex second = std::exp(kTwoModes[1] * u);
  EXPECT_NEAR(x(7), second.real(), 1e-12);
  EXPECT_NEAR(x(8), -second.imag(), 1e-12);
  EXPECT_NEAR(x(11), std::abs(kTwoModes[1]) * u * second.real(), 1e-10);
  EXPECT_NEAR(x(13), kTurning * u * std::sin(kTurning * u), 1e-10);
}

TEST(ModalRegressors, TurnedFromInstantToInstantAreAsComputedAnew) {
  ModalRegressors turned(1, 4), anew(1, 4);
  turned.restart(kTurning, 0.0, 0, kTwoModes);
  for (int i = 0; i < 3000; ++i) {
    const Eigen::VectorXd& x = turned.at(i * kStep_ns);
    if (i % 37 != 0) continue;
    anew.restart(kTurning, 0.0, 0, kTwoModes);
    EXPECT_LT((x.head(13) - anew.at(i * kStep_ns).head(13)).cwiseAbs().maxCoeff(), 1e-8) << i;
  }
}

TEST(ModalRegressors, GoBackInTimeAsWell) {
  ModalRegressors regressors(1, 4);
  regressors.restart(kTurning, 0.0, 0, kTwoModes);
  const double before = regressors.at(40 * kStep_ns)(3);
  static_cast<void>(regressors.at(80 * kStep_ns));
  EXPECT_NEAR(regressors.at(40 * kStep_ns)(3), before, 1e-13);
}

TEST(ModalRegressors, FollowADriveThatDrifts) {
  ModalRegressors regressors(1, 4);
  regressors.restart(kTurning, 0.2, 0, {});
  const double u = 2.0;
  EXPECT_NEAR(regressors.angle(2'000'000'000), kTurning * u + 0.1 * u * u, 1e-12);
  EXPECT_NEAR(regressors.at(2'000'000'000)(1), std::sin(kTurning * u + 0.1 * u * u), 1e-12);
}

TEST(ModalRegressors, AModeThatHasFadedIsNothingUntilTheNextRestart) {
  ModalRegressors regressors(1, 4);
  regressors.restart(kTurning, 0.0, 0, kTwoModes);
  regressors.fade(0, 100 * kStep_ns);
  EXPECT_NE(regressors.at(99 * kStep_ns)(3), 0.0);
  EXPECT_EQ(regressors.at(100 * kStep_ns).segment<2>(3).norm(), 0.0);
  EXPECT_EQ(regressors.at(100 * kStep_ns).segment<2>(7).norm(), 0.0);
  EXPECT_NE(regressors.at(100 * kStep_ns)(5), 0.0);
  regressors.restart(kTurning, 0.0, 0, kTwoModes);
  EXPECT_NE(regressors.at(100 * kStep_ns)(3), 0.0);
}

TEST(ModalRegressors, PolesBeyondTheCapacityAreLeftOut) {
  ModalRegressors regressors(1, 1);
  regressors.restart(kTurning, 0.0, 0, kTwoModes);
  EXPECT_EQ(regressors.poles().size(), 1u);
  EXPECT_EQ(regressors.poles()[0], kTwoModes[0]);
  EXPECT_EQ(ModalRegressors(1, 50).capacity(), std::size_t{ModalRegressors::kMaxModes});
}

}  // namespace
}  // namespace dwell
