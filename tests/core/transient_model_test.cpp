// The transient of one hold, from its first periods to the data that count.
#include "core/transient/transient_model.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

Rig rig_of_two_channels() {
  Rig rig = rig_of_one_mass();
  rig.excitation.harmonics = 1;
  rig.channels.resize(2);
  return rig;
}

// Plays the motion a quarter of a period at a time, as the pipeline does.
struct ModelledMotion : FreeMotion {
  Rig two = rig_of_two_channels();
  StatedPoles chain{{{-0.6, 33.3}}};
  TransientModel model{two, {}, history, chain};
  SettlingDetector::Verdict verdict;
  std::int64_t counts_from_ns = -1;
  static constexpr SeenFrequency kDriven{kDrive, 0.0, 0};

  explicit ModelledMotion(std::uint64_t seed) : FreeMotion(seed) { model.begin_hold(0); }

  // One quarter more; whether the model gives a verdict.
  bool settles_in_quarter(const Beside& beside = nothing) {
    play(kPeriodLength_s / kQuarters, beside);
    for (int c = 0; c < 2; ++c) model.noise().learn(c, 20 * kRms * kRms, 20);
    const HoldNow at = now();
    if (model.too_early(at.now_ns, at)) return false;
    if (model.wants_refit(at.now_ns, at) && !model.refit(kDriven, at.now_ns, at)) return false;
    if (!model.fitted()) return false;
    const auto judged = model.judge(verdict.worst_left, at.now_ns, at);
    verdict = judged.verdict;
    if (judged.counts_from_ns) counts_from_ns = *judged.counts_from_ns;
    return judged.counts_from_ns.has_value();
  }
  bool settles_before(double until_s, const Beside& beside = nothing) {
    while (seconds < until_s - 1e-9)
      if (settles_in_quarter(beside)) return true;
    return false;
  }
};

TEST(TransientModel, SettlesWhereTheModeHasDecayedToWhatIsAllowed) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ModelledMotion motion(seed);
    ASSERT_TRUE(motion.settles_before(30)) << seed;
    // 0.6 exp(-0.5 t) = 0.85 · 0.005 at 9.9 s; noise and six quarters that must count come on top.
    EXPECT_GT(motion.seconds, 9.8) << seed;
    EXPECT_LT(motion.seconds, 13.0) << seed;
    EXPECT_LT(std::abs(motion.model.poles().chain.at(0) - FreeMotion::kMode), 0.01) << seed;
  }
}

TEST(TransientModel, SaysWhichChannelHoldsItUpAndForHowLong) {
  ModelledMotion motion(2);
  ASSERT_FALSE(motion.settles_before(6));
  EXPECT_EQ(motion.verdict.worst_channel, 1);
  EXPECT_NEAR(motion.verdict.settles_in_s, 9.9 - 6, 0.5);
}

TEST(TransientModel, WithoutPolesToBeginWithHasNothingToSay) {
  ModelledMotion motion(3);
  motion.chain = StatedPoles({});
  EXPECT_FALSE(motion.settles_before(14));
  EXPECT_FALSE(motion.model.fitted());
  EXPECT_FALSE(motion.model.has_poles());
}

TEST(TransientModel, AKnockPutsTheVerdictOff) {
  ModelledMotion motion(4);
  const auto knock = [](int c, double t) {
    return t < 8.0 ? 0.0 : 0.3 * (c + 1) * std::exp(FreeMotion::kMode * (t - 8.0)).imag();
  };
  ASSERT_TRUE(motion.settles_before(40, knock));
  EXPECT_GT(motion.seconds, 17.5);
  EXPECT_GE(motion.counts_from_ns, to_ns(16.0));
}

TEST(TransientModel, ANewHoldForgetsTheFormer) {
  ModelledMotion motion(5);
  ASSERT_TRUE(motion.settles_before(30));
  motion.model.take_out(motion.counts_from_ns, motion.now().now_ns, motion.now());
  motion.model.begin_hold(motion.now().now_ns);
  EXPECT_FALSE(motion.model.fitted());
  EXPECT_FALSE(motion.model.has_poles());
  EXPECT_FALSE(motion.model.removal().active());
  EXPECT_TRUE(motion.model.modes().empty());
  EXPECT_TRUE(motion.model.too_early(motion.now().now_ns + to_ns(0.5), motion.now()));
}

// A motion that has settled and is being measured.
struct MeasuredMotion : ModelledMotion {
  explicit MeasuredMotion(std::uint64_t seed) : ModelledMotion(seed) {
    EXPECT_TRUE(settles_before(30));
    model.begin_measuring(now());
    model.take_out(counts_from_ns, now().now_ns, now());
  }
};

TEST(TransientModel, FollowsTheFrequencyOfTheDataThatCountOnlyWhereThatExplainsTheHoldBetter) {
  MeasuredMotion motion(6);
  SeenFrequency counted = ModelledMotion::kDriven;
  counted.u = 1e-5;
  motion.model.allow_following();
  EXPECT_FALSE(motion.model.follow_drive(counted, motion.now())) << "it is the same";
  counted.omega *= 1.01;
  EXPECT_FALSE(motion.model.follow_drive(counted, motion.now())) << "it explains less";
  EXPECT_EQ(motion.model.fit().omega(), FreeMotion::kDrive);
}

TEST(TransientModel, RefinesTheModesWhenTheHoldHasDoubledUntilNothingCanHideAnyMore) {
  MeasuredMotion motion(7);
  EXPECT_FALSE(motion.model.wants_refit_measuring(motion.now()));
  const double verdict_s = motion.seconds;
  motion.play(verdict_s + 0.1);
  ASSERT_TRUE(motion.model.wants_refit_measuring(motion.now()));
  EXPECT_TRUE(motion.model.refit_measuring(ModelledMotion::kDriven, false, motion.now())) << "e^-12 of it is left";
  EXPECT_EQ(motion.model.fit().samples(0), std::lround((motion.seconds - to_s(motion.model.fit().t0_ns())) * 400));
  motion.model.end_refits();
  motion.play(4 * verdict_s);
  EXPECT_FALSE(motion.model.wants_refit_measuring(motion.now()));
}

TEST(TransientModel, GoesOnWhileWhatIsNotKnownOfTheTransientMatters) {
  MeasuredMotion motion(8);
  motion.play(motion.seconds + 0.1);
  ASSERT_TRUE(motion.model.wants_refit_measuring(motion.now()));
  EXPECT_FALSE(motion.model.refit_measuring(ModelledMotion::kDriven, true, motion.now()));
}

TEST(TransientModel, TakesBackAVerdictAtWhichTooMuchWasLeftAndSettlesAgain) {
  MeasuredMotion motion(9);
  EXPECT_FALSE(motion.model.takes_back(motion.now().now_ns, motion.now()));
  EXPECT_FALSE(motion.model.taken_back());
  ASSERT_TRUE(motion.model.takes_back(to_ns(4), motion.now()));
  ASSERT_TRUE(motion.model.taken_back());
  EXPECT_EQ(motion.model.taken_back()->verdict_ns, to_ns(4));
  const auto mended_ns = motion.model.mend(motion.now().now_ns, motion.now(), motion.verdict);
  ASSERT_TRUE(mended_ns) << "by now it has settled";
  EXPECT_GT(*mended_ns, to_ns(8));
  motion.model.settle_again(motion.now());
  EXPECT_FALSE(motion.model.removal().active());
  EXPECT_TRUE(motion.model.fitted());
}

TEST(TransientModel, KeepsTheModeThatTheHoldHasShown) {
  MeasuredMotion motion(10);
  motion.model.remember_modes(motion.now());
  ASSERT_EQ(motion.model.modes().size(), 1u);
  const SeenMode& mode = motion.model.modes()[0];
  EXPECT_LT(std::abs(mode.pole - FreeMotion::kMode), 4 * std::sqrt(mode.pole_covariance().trace()));
}

}  // namespace
}  // namespace dwell
