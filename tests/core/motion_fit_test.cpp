#include "core/motion/motion_fit.hpp"

#include <gtest/gtest.h>

#include "core/motion/motion_recorder.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

struct Fitted {
  Fitted() : rig(rig_of(free_chain(), 4.0)), model(rig, free_parameters(rig, 1)) {
    DrivenChain driven(free_chain(), {4.0, 0.005, 0.001, 0.3}, DrivenChain::Start::rest);
    data = readings_of(rig, driven, 0.0, 2.0, 200.0, {1e-5, 1e-5, 1e-5}, 4);
    limits.lowest = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(model.parameters().size()), -1e300);
  }
  MotionFit from(double part) const {
    Chain chain = free_chain();
    for (double& c : chain.stiffness) c *= part;
    for (double& r : chain.damping) r /= part;
    const Eigen::VectorXd theta = theta_of(model.parameters(), chain, {3e-5, 3e-5, 3e-5}, std::log(1e-5));
    return fit_motion(model, data, {theta, Eigen::VectorXd::Zero(model.states()), Eigen::VectorXd::Zero(3)}, limits);
  }
  Rig rig;
  MotionModel model;
  MotionData data;
  FitLimits limits;
};

TEST(MotionFit, ComesToTheSameFromOtherStarts) {
  const Fitted at;
  const MotionFit one = at.from(0.9), other = at.from(1.08);
  ASSERT_TRUE(one.converged && other.converged);
  for (Eigen::Index a = 0; a < 4; ++a)
    EXPECT_NEAR(one.at.theta(a), other.at.theta(a), 0.1 * std::sqrt(one.covariance(a, a))) << a;
}

// The table's mean and the biases of displacements: one direction, and no coefficient lies in it.
TEST(MotionFit, LeavesOutTheGaugeOfTheBiases) {
  const Fitted at;
  const MotionFit fit = at.from(1.0);
  ASSERT_TRUE(fit.converged);
  EXPECT_LT(fit.undetermined.head(4).maxCoeff(), 1e-6);
  EXPECT_NEAR(fit.undetermined.tail(at.model.states() + 3).sum(), 1.0, 0.01);
}

TEST(MotionFit, HoldsAnIntensityAtItsBound) {
  Fitted at;
  const Eigen::Index q = 4;
  at.limits.lowest(q) = std::log(1e-6);  // the steady part of the motion would have less
  DrivenChain steady(free_chain(), {4.0, 0.005, 0.0, 0.0}, DrivenChain::Start::steady);
  at.data = readings_of(at.rig, steady, 0.0, 3.0, 200.0, {1e-5, 1e-5, 1e-5}, 4);
  const MotionFit fit = at.from(1.02);
  ASSERT_TRUE(fit.converged);
  EXPECT_EQ(fit.at.theta(q), std::log(1e-6));
  EXPECT_EQ(fit.covariance(q, q), 0.0);
}

TEST(MotionRecorder, GivesReadingsInSIAtTheInstantsOfTheMotion) {
  Rig rig = rig_of(free_chain(), 4.0);
  rig.channels[1].delay_s = 0.002;
  rig.channels[1].scale = 2.0;
  rig.channels[1].si_per_unit = 1e-3;
  rig.channels[1].range_high = 10.0;
  MotionRecorder recorder(rig);
  const auto give = [&](double t_s, int channel, double value) {
    Record record;
    record.t_ns = to_ns(t_s);
    record.channel = static_cast<std::uint16_t>(channel);
    record.value = value;
    recorder.take(record);
  };
  give(1.000, 0, 0.5);
  give(1.001, 1, 3.0);
  give(1.003, 1, 6.0);  // 12 mm: beyond its range
  give(1.004, 0, std::nan(""));
  const MotionData data = recorder.data();
  ASSERT_EQ(data.readings.size(), 2U);
  EXPECT_EQ(data.readings[0].channel, 1);
  EXPECT_EQ(data.readings[0].t_ns, to_ns(0.999));
  EXPECT_NEAR(data.readings[0].value, 6e-3, 1e-12);
  EXPECT_EQ(data.readings[1].channel, 0);
}

}  // namespace
}  // namespace dwell
