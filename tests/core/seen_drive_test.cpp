// What is said of a table that counts as at rest.
#include "core/drive/seen_drive.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

TEST(SeenDrive, ATableThatMovedWhenLastHeardIsNotSaidToBeAtRest) {
  Rig rig;
  rig.excitation.minimum = 1e-5;
  SeenDrive seen;
  seen.take(1e-6, 4.0, false);
  EXPECT_NE(seen.at_rest(rig).find("does not move"), std::string::npos) << seen.at_rest(rig);
  seen.take(5e-3, 4.0, true);
  EXPECT_EQ(seen.at_rest(rig).find("does not move"), std::string::npos) << seen.at_rest(rig);
  EXPECT_NE(seen.at_rest(rig).find("5 mm"), std::string::npos) << seen.at_rest(rig);
}

TEST(SeenDrive, SaysNoAmplitudesBeforeOneCounts) {
  const Rig rig;
  SeenDrive seen;
  seen.arm();
  seen.take(5e-3, 4.0, true);
  EXPECT_EQ(seen.unsteady(rig, 1.0, {}), "too few periods seen since the drive began");
  for (int quarter = 0; quarter < 4; ++quarter) seen.take(5e-3, 4.0, true);
  EXPECT_NE(seen.unsteady(rig, 1.0, {}).find("between 5 mm and 5 mm"), std::string::npos)
      << seen.unsteady(rig, 1.0, {});
}

TEST(SeenDrive, SwingsWhereTheAmplitudeChangesByMoreThanTheTolerance) {
  Rig rig;
  rig.tolerance = 0.005;
  SeenDrive seen;
  seen.arm();
  EXPECT_FALSE(seen.swings(rig)) << "nothing is seen yet";
  for (int quarter = 0; quarter < 5; ++quarter) seen.take(5e-3, 4.0, true);
  EXPECT_FALSE(seen.swings(rig));
  seen.take(4.98e-3, 4.0, true);
  EXPECT_FALSE(seen.swings(rig)) << "0.4 %";
  seen.take(4.97e-3, 4.0, true);
  EXPECT_TRUE(seen.swings(rig)) << "0.6 %";
}

}  // namespace
}  // namespace dwell
