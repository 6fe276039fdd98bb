// Readings turned into what the chain shows.
#include "core/chain/observed.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/complex.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

TEST(Observed, AVelocityReadLateIsTheDisplacementAgain) {
  Rig rig = rig_of(clamped_chain(), 4);
  rig.channels[1].measures = Quantity::velocity;
  rig.channels[1].delay_s = 2e-3;
  const double omega = 2 * M_PI * 4;
  const Complex y{1e-3, 2e-3}, read = y * Complex{0.0, omega} * std::polar(1.0, -omega * 2e-3);
  EXPECT_LT(std::abs(as_observed(rig, 1, read, omega, 1) - y), 1e-15);
  EXPECT_LT(std::abs(as_observed(rig, 1, read, Complex{0.0, omega}) - y), 1e-15);
}

TEST(Observed, AForceOnTheMassIsTheForceOnTheGroundReversed) {
  Rig rig = rig_of(clamped_chain(), 4);
  rig.channels[3].force_on_mass = true;
  EXPECT_EQ(as_observed(rig, 3, {5.0, 1.0}, 25.0, 1), (Complex{-5.0, -1.0}));
}

// A corner and a delay higher than stated, a scale larger: the natural oscillation that is observed falls short of the
// true one by that part.
TEST(Observed, TooSmallIsByWhatARigReadsThatIsNotAsStated) {
  Rig stated = rig_of(clamped_chain(), 4);
  stated.channels[1].lowpass = {FilterKind::butterworth, 2, 60, 0};
  stated.channels[1].highpass = {FilterKind::rc, 1, 0.5, 0};
  const Complex pole{-3.0, 40.0};
  const ReadingError error{.channel = 1, .late_s = 1e-6, .lowpass_hz = 1e-3, .highpass_hz = 1e-4};
  Rig actual = stated;
  actual.channels[1].delay_s += error.late_s;
  actual.channels[1].lowpass.hz += error.lowpass_hz;
  actual.channels[1].highpass.hz += error.highpass_hz;
  const Complex read = 1.0 / as_observed(actual, 1, 1.0, pole);  // of an oscillation of amplitude 1
  const Complex short_by = 1.0 - as_observed(stated, 1, read, pole);
  EXPECT_LT(std::abs(observed_too_small(stated, error, pole) - short_by), 1e-3 * std::abs(short_by));
  EXPECT_EQ(observed_too_small(stated, {.channel = 1, .relative = 0.01}, pole), Complex{0.01});
}

TEST(Observed, WeightsAreOneOverTheRelativeUncertaintyAmongChannelsOfOneKind) {
  const Rig rig = rig_of(clamped_chain(), 4);
  std::vector<Evidence> evidence(4);
  for (std::size_t c = 0; c < 4; ++c) {
    evidence[c].usable = c != 2;
    evidence[c].X[0] = 1e-3;
    const double noise = c == 1 ? 2e-6 : 1e-6;
    evidence[c].covariance = noise * noise * Eigen::Matrix2d::Identity();
  }
  const Eigen::VectorXd weights = observation_weights(rig, evidence, 25.0);
  EXPECT_NEAR(weights(0), 1.0, 1e-12);
  EXPECT_NEAR(weights(1), 0.5, 1e-6);
  EXPECT_EQ(weights(2), 0.0);
  EXPECT_NEAR(weights(3), 1.0, 1e-12);  // the only force
}

}  // namespace
}  // namespace dwell
