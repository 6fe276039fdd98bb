// The transient is taken out of the readings that count.
#include "core/transient/transient_removal.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

struct RemovedMotion : FreeMotion {
  Rig rig = rig_of_one_mass();
  TransientRemoval removal{rig, fit};

  explicit RemovedMotion(std::uint64_t seed) : FreeMotion(seed) {
    play(8);
    fit_all(kPeriodLength_s, std::vector<Complex>{kMode});
    fit.fit().propagate_poles(true);
  }
  // Largest distance of channel 1's cleaned readings in [from, to) from the steady motion.
  double worst(double from_s, double to_s) {
    double worst = 0.0;
    for (auto i = history.first_at(to_ns(from_s)); i < history.first_at(to_ns(to_s)); ++i) {
      const auto& s = history[i];
      if (s.channel != 1) continue;
      const double steady = std::sin(kDrive * 1e-9 * static_cast<double>(s.t_ns) + 1);
      worst = std::max(worst, std::abs(removal.clean(1, s.t_ns, s.value) - steady));
    }
    return worst;
  }
};

TEST(TransientRemoval, LeavesTheSteadyMotionAndNoise) {
  RemovedMotion motion(1);
  EXPECT_GT(motion.worst(1, 2), 0.2) << "nothing is subtracted yet";
  motion.removal.begin(to_ns(1), to_ns(8));
  EXPECT_TRUE(motion.removal.active());
  EXPECT_LT(motion.worst(1, 8), 6 * FreeMotion::kRms);
}

TEST(TransientRemoval, GoesOnUntilTheModeIsNegligibleThenCostsNothing) {
  RemovedMotion motion(2);
  motion.removal.begin(to_ns(1), to_ns(2));
  const double value = 0.5;
  // 0.6 exp(-0.5 t) falls below a thousandth of the tolerance at 23 s.
  EXPECT_NE(motion.removal.clean(1, to_ns(10), value), value);
  EXPECT_EQ(motion.removal.clean(1, to_ns(60), value), value);
}

TEST(TransientRemoval, StopsWhereItIsTold) {
  RemovedMotion motion(3);
  motion.removal.begin(to_ns(1), to_ns(8));
  motion.removal.stop();
  EXPECT_FALSE(motion.removal.active());
  EXPECT_EQ(motion.removal.clean(1, to_ns(2), 0.5), 0.5);
}

TEST(TransientRemoval, WhatIsNotKnownOfItIsLessThanItselfAndTellsLessInMoreReadings) {
  RemovedMotion motion(4);
  motion.removal.begin(to_ns(1), to_ns(8));
  EXPECT_EQ(motion.removal.covariance(1, 100).norm(), 0.0) << "no reading has been cleaned";
  static_cast<void>(motion.worst(1, 2));
  const double of_fewer = std::sqrt(motion.removal.covariance(1, FreeMotion::kSamples_hz).trace());
  EXPECT_GT(of_fewer, 0.0);
  EXPECT_LT(of_fewer, 0.1 * 2 / FreeMotion::kSamples_hz * motion.removal.taken_out(1).norm());
  static_cast<void>(motion.worst(2, 8));
  EXPECT_LT(std::sqrt(motion.removal.covariance(1, 7 * FreeMotion::kSamples_hz).trace()), of_fewer);
}

}  // namespace
}  // namespace dwell
