// What a hold has shown of its natural oscillations, for the check of the model.
#include "core/transient/shown_modes.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

struct ShownMotion : FreeMotion {
  StatedPoles chain{{kMode}};
  ShownModes shown{chain, 2, 1, 6, {}};

  explicit ShownMotion(std::uint64_t seed) : FreeMotion(seed) {}
  void fit_from(double from_s, const std::vector<Complex>& poles) {
    fit_all(from_s, poles);
    noise.compare_halves(fit, now().now_ns);
    shown.remember(fit, noise, 0, now());
  }
};

TEST(ShownModes, TellsOfAModeThatDecaysBeforeTheFitBegins) {
  const Complex fast{-6.0, 95.0};
  ShownMotion motion(1);
  motion.play(8, [&](int c, double t) { return 0.3 * (c + 1) * std::exp(fast * t).real(); });
  motion.learn_noise();
  motion.fit_from(2.5, {FreeMotion::kMode});
  ASSERT_EQ(motion.shown.modes().size(), 2u);
  for (const SeenMode& mode : motion.shown.modes()) {
    const Complex truth = mode.pole.imag() > 60 ? fast : FreeMotion::kMode;
    EXPECT_LT(std::abs(mode.pole - truth), 4 * std::sqrt(mode.pole_covariance().trace()));
  }
}

TEST(ShownModes, OfAFitThatDoesNotExplainTheDataKeepsOnlyWhatItShows) {
  const Complex beside{-0.6, 95.0};
  ShownMotion motion(2);
  motion.play(8, [&](int c, double t) { return 0.05 * (c + 1) * std::exp(beside * t).real(); });
  motion.learn_noise();
  motion.fit_from(0.2, {FreeMotion::kMode});
  EXPECT_FALSE(motion.noise.explained(motion.fit.fit(), motion.now()));
  for (const SeenMode& mode : motion.shown.modes()) EXPECT_LT(mode.pole.imag(), 60.0);
}

TEST(ShownModes, ANewHoldHasShownNothing) {
  ShownMotion motion(3);
  motion.play(8);
  motion.learn_noise();
  motion.fit_from(0.2, {FreeMotion::kMode});
  EXPECT_EQ(motion.shown.modes().size(), 1u);
  motion.shown.begin_hold();
  EXPECT_TRUE(motion.shown.modes().empty());
}

}  // namespace
}  // namespace dwell
