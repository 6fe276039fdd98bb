#include "core/motion/motion_fit.hpp"

#include <gtest/gtest.h>

#include "core/motion/motion_estimate.hpp"
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

// A step that was just taken says nothing of how far it is from there.
TEST(MotionFit, HasNotConvergedWherePassesRunOutOnTheWay) {
  Fitted at;
  for (const int passes : {3, 4}) {
    at.limits.passes = passes;
    const MotionFit fit = at.from(0.8);
    EXPECT_EQ(fit.passes, passes);
    EXPECT_GT(fit.left, 1.0) << passes;
    EXPECT_FALSE(fit.converged) << passes;
  }
}

TEST(MotionRecorder, GivesReadingsInSIAtTheInstantsOfTheMotion) {
  Rig rig = rig_of(free_chain(), 4.0);
  rig.channels[1].delay_s = 0.002;
  rig.channels[1].scale = 2.0;
  rig.channels[1].si_per_unit = 1e-3;
  rig.channels[1].range.high = 10.0;
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

// At rest for 20 s, then driven for 40 s, harder from the middle on: of 36 000 readings an estimate takes 4 000.
TEST(MotionRecorder, OfALongRecordingKeepsWhatGivesTheSameEstimateToTheLastBit) {
  Rig rig = rig_of(clamped_chain(), 4.0);
  rig.excitation.minimum = 2e-5;
  DrivenChain chain(clamped_chain(), {.frequency_hz = 4.0, .amplitude = 1e-3}, DrivenChain::Start::rest);
  // Noise of a thousandth of each amplitude: 1 µm, and 20 mN of the reaction.
  std::vector<double> sigma;
  for (const Channel& channel : rig.channels) sigma.push_back(channel.measures == Quantity::force ? 0.02 : 1e-6);
  const MotionData played = readings_of(rig, chain, 0.0, 40.0, 150.0, sigma, 5);
  std::mt19937_64 rng(9);
  std::normal_distribution<double> normal;
  const std::size_t channels = rig.channels.size();
  MotionRecorder all(rig, SIZE_MAX), few(rig, 9000);
  const auto give = [&](std::int64_t t_ns, int channel, double value) {
    Record record;
    record.t_ns = t_ns;
    record.channel = static_cast<std::uint16_t>(channel);
    record.value = value;
    all.take(record);
    few.take(record);
  };
  for (int i = 0; i < 3000; ++i)
    for (std::size_t c = 0; c < channels; ++c) give(to_ns(i / 150.0), static_cast<int>(c), sigma[c] * normal(rng));
  for (const MotionReading& r : played.readings) {
    const double times = r.t_ns > to_ns(20.0) ? 5.0 : 1.0;  // not as a chain would: only the activity matters there
    give(r.t_ns + to_ns(20.0), r.channel, times * r.value);
  }
  EXPECT_LE(few.data().readings.size(), 11000U);
  EXPECT_GT(all.data().readings.size(), 30000U);
  const MotionOptions options{.most_work = 16000, .missing = false};
  const MotionEstimate a = estimate_motion(rig, all.data(), options), b = estimate_motion(rig, few.data(), options);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.readings, b.readings);
  EXPECT_EQ(a.start_s, b.start_s);
  EXPECT_EQ(a.end_s, b.end_s);
  ASSERT_FALSE(a.elements.empty()) << a.reason;
  ASSERT_EQ(a.elements.size(), b.elements.size());
  EXPECT_EQ(a.covariance, b.covariance);
  for (std::size_t k = 0; k < a.elements.size(); ++k) {
    EXPECT_EQ(a.elements[k].stiffness.value, b.elements[k].stiffness.value);
    EXPECT_EQ(a.elements[k].stiffness.U95, b.elements[k].stiffness.U95);
    EXPECT_EQ(a.elements[k].damping.value, b.elements[k].damping.value);
  }
}

}  // namespace
}  // namespace dwell
