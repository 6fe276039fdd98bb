// The search for better poles of a hold.
#include "core/transient/pole_search.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

TEST(PoleSearch, FindsAPoleThatIsALittleOff) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SearchedMotion motion(seed, {});
    motion.play(6);
    const double before = motion.begin(0.2, {}, {{-0.6, 33.6}});
    const double after = motion.search.refine(before, PoleSearch::kManySteps, motion.now());
    EXPECT_LT(after, before);
    EXPECT_LT(std::abs(motion.search.best()[0] - FreeMotion::kMode), 4 * motion.fit.fit().u_pole(0)) << seed;
    motion.search.take_best();
    EXPECT_EQ(motion.search.poles().chain, motion.search.best());
  }
}

TEST(PoleSearch, FindsTheDrivesFrequencyInTheSameStepsUnlessItIsGiven) {
  for (const bool given : {false, true}) {
    SearchedMotion motion(2, {});
    motion.play(6);
    motion.begin(0.2, {}, {FreeMotion::kMode});
    const double told = 1.0005 * FreeMotion::kDrive;
    double misfit = motion.fit.anew(told, motion.search.best(), motion.channels);
    HoldNow now = motion.now();
    now.omega_given = given;
    misfit = motion.search.refine(misfit, PoleSearch::kManySteps, now);
    EXPECT_EQ(motion.fit.fit().omega() == told, given);
    if (!given) {
      EXPECT_NEAR(motion.fit.fit().omega(), FreeMotion::kDrive, 1e-5 * FreeMotion::kDrive);
    }
  }
}

TEST(PoleSearch, MakesNoMoreFitsThanAreAllowed) {
  SearchedMotion motion(3, {});
  motion.play(6);
  const double before = motion.begin(0.2, {}, {{-0.6, 33.6}});
  motion.fit.allow(0);
  EXPECT_EQ(motion.search.refine(before, PoleSearch::kManySteps, motion.now()), before);
  EXPECT_EQ(motion.search.best()[0], (Complex{-0.6, 33.6}));
}

TEST(PoleSearch, ATrialThatExplainsLessIsDropped) {
  SearchedMotion motion(4, {});
  motion.play(6);
  const double before = motion.begin(0.2, {}, {FreeMotion::kMode});
  motion.search.trial().assign({Complex{-0.6, 34.0}});
  EXPECT_EQ(motion.search.try_trial(FreeMotion::kDrive, before, motion.now()), before);
  EXPECT_EQ(motion.search.best()[0], FreeMotion::kMode);
  EXPECT_EQ(motion.fit.fit().poles()[0], FreeMotion::kMode);
}

TEST(PoleSearch, TakesThoseBesideTheChainFirst) {
  SearchedMotion motion(5, {});
  motion.search.poles().beside = {{-1.0, 100.0}};
  motion.search.best() = {{-1.1, 101.0}, {-0.5, 33.0}, {-2.0, 60.0}};
  motion.search.take_best();
  EXPECT_EQ(motion.search.poles().beside, (std::vector<Complex>{{-1.1, 101.0}}));
  EXPECT_EQ(motion.search.poles().chain, (std::vector<Complex>{{-0.5, 33.0}, {-2.0, 60.0}}));
}

TEST(PoleSearch, LeavesOutWhatHasDecayedWhatGrowsAndWhatIsThereTwice) {
  SearchedMotion motion(6, {});
  motion.play(6);
  motion.fit.begin_at(to_ns(1.0));
  motion.search.poles().beside = {{0.0, 314.0}};
  std::vector<Complex> out;
  // 20 /s for a second: a part in 10⁸ is left. 0.05 rad/s apart: less than 0.3 rad over five seconds.
  const std::vector<Complex> chain{{-0.5, 33.0}, {-0.5, 33.05}, {-20.0, 90.0}, {0.2, 60.0}};
  motion.search.still_there(chain, 0, motion.now(), out);
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[0], (Complex{0.0, 314.0}));
  EXPECT_EQ(out[1], chain[0]);
  EXPECT_LT(out[2].real(), 0.0) << "a pole that grows is taken as hardly damped";
  EXPECT_EQ(out[2].imag(), 60.0);
}

}  // namespace
}  // namespace dwell
