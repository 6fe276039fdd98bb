#include "core/transient/pole_step.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/complex.hpp"
#include "tests/core/modal_channel.hpp"

namespace dwell {
namespace {

const ModalChannel::Truth kRinging{{{-0.5, 33.0}}, {{0.7, 0.3}}, 1e-3, 4.0};

PoleStep step_of(ModalChannel& channel, double trust, double trust_omega, const FrequencyPrior& stated = {}) {
  PoleStep step(ModalChannel::kMost);
  EXPECT_TRUE(channel.solve());
  step.begin(channel.layout());
  EXPECT_TRUE(channel.eliminate());
  step.add(channel.layout(), channel.motion(), channel.sums, channel.solution, channel.linear.beyond(channel.layout()));
  step.take(channel.layout(), channel.motion(), stated, trust, trust_omega);
  return step;
}

TEST(PoleStep, LeadsNearlyAllTheWayToAPoleThatIsNotFar) {
  const Complex truth = kRinging.poles[0], told = truth * Complex{1.0, 0.001};
  ModalChannel channel(kRinging, {told});
  const PoleStep step = step_of(channel, 0.05, 0.0);
  EXPECT_LT(std::abs(step.poles()[0] - truth), 0.1 * std::abs(told - truth));
  EXPECT_GT(step.length(), 1.0);
  EXPECT_EQ(step.omega(), ModalChannel::kOmega) << "ω is known";
}

TEST(PoleStep, GoesNoFurtherThanItIsTrusted) {
  ModalChannel channel(kRinging, {{-0.5, 36.0}});
  const PoleStep step = step_of(channel, 1e-3, 0.0);
  EXPECT_LE(std::abs(step.poles()[0] - Complex{-0.5, 36.0}), 2.001e-3 * 36.1);
}

TEST(PoleStep, FindsTheDrivesFrequencyWithinItsTrust) {
  ModalChannel::Truth truth = kRinging;
  truth.omega *= 1 + 1e-4;
  ModalChannel channel(truth, kRinging.poles);
  EXPECT_NEAR(step_of(channel, 0.05, 1e-2).omega() / ModalChannel::kOmega - 1, 1e-4, 2e-5);
  ModalChannel again(truth, kRinging.poles);
  EXPECT_LE(step_of(again, 0.05, 2e-5).omega() / ModalChannel::kOmega - 1, 2.001e-5);
}

TEST(PoleStep, AStatedFrequencyHoldsIt) {
  ModalChannel::Truth truth = kRinging;
  truth.omega *= 1 + 1e-4;
  ModalChannel channel(truth, kRinging.poles);
  const PoleStep step = step_of(channel, 0.05, 1e-2, {ModalChannel::kOmega, 1e-9});
  EXPECT_NEAR(step.omega() / ModalChannel::kOmega - 1, 0.0, 1e-8);
}

TEST(PoleStep, ASteadyLineStaysOnTheAxisAndATransientDecays) {
  const ModalChannel::Truth truth{{{0.0, 45.0}, {0.01, 33.0}}, {{0.1, 0.05}, {0.5, 0.0}}, 1e-3, 4.0};
  ModalChannel channel(truth, {{0.0, 45.02}, {-0.1, 33.0}});
  const PoleStep step = step_of(channel, 0.05, 0.0);
  EXPECT_EQ(step.poles()[0].real(), 0.0);
  EXPECT_LT(step.poles()[1].real(), 0.0) << "though the data grow";
}

TEST(PoleStep, TheStatedUncertaintyCoversThePole) {
  double chi2 = 0.0, covariance = 0.0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    ModalChannel channel(kRinging, kRinging.poles, seed);
    const PoleStep step = step_of(channel, 0.05, 0.0);
    const Complex off = step.poles()[0] - kRinging.poles[0];
    chi2 += std::norm(off) / (2 * step.u_pole(0) * step.u_pole(0)) / 200;
    covariance +=
        std::norm(kRinging.poles[0]) * step.covariance(0).trace() / (2 * step.u_pole(0) * step.u_pole(0)) / 200;
  }
  EXPECT_NEAR(chi2, 1.0, 0.25) << "400 degrees of freedom: a relative spread of 0.07";
  EXPECT_NEAR(covariance, 1.0, 0.05) << "of the data alone: the trust is far wider";
}

TEST(PoleStep, ChannelsWithUnlikePolesDisagree) {
  for (const double off : {0.0, 0.3}) {
    ModalChannel::Truth other = kRinging;
    other.poles[0] += Complex{0.0, off};
    const ModalChannel::Poles told{kRinging.poles[0] + Complex{0.0, off / 2}};
    ModalChannel one(kRinging, told, 1), two(other, told, 2);
    PoleStep step(ModalChannel::kMost);
    step.begin(one.layout());
    for (ModalChannel* channel : {&one, &two}) {
      ASSERT_TRUE(channel->solve());
      ASSERT_TRUE(channel->eliminate());
      step.add(channel->layout(), channel->motion(), channel->sums, channel->solution,
               channel->linear.beyond(channel->layout()));
    }
    if (off == 0) {
      EXPECT_LT(step.disagreement(0), 12.0) << "χ² of two degrees of freedom";
    } else {
      EXPECT_GT(step.disagreement(0), 100.0);
    }
  }
}

}  // namespace
}  // namespace dwell
