// A line at a harmonic of the drive that the fit leaves out is told as that.
#include "core/fit/drive_harmonic.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

constexpr double kDrive = 25.0;  // rad/s

TEST(DriveHarmonic, IsTheMultipleAtWhichTheLineLies) {
  EXPECT_EQ(unfitted_harmonic(4 * kDrive + 0.1, kDrive, 0.2, 3), 4);
  EXPECT_EQ(unfitted_harmonic(4 * kDrive - 0.1, kDrive, 0.2, 3), 4);
  EXPECT_EQ(unfitted_harmonic(4 * kDrive + 0.3, kDrive, 0.2, 3), 0);
}

TEST(DriveHarmonic, IsNoneThatIsFitted) {
  EXPECT_EQ(unfitted_harmonic(3 * kDrive, kDrive, 0.2, 3), 0);
  EXPECT_EQ(unfitted_harmonic(0.1, kDrive, 0.2, 0), 0) << "rest is no harmonic";
}

TEST(DriveHarmonic, IsNotToldOfALineThatMayLieAnywhere) {
  EXPECT_EQ(unfitted_harmonic(4 * kDrive, kDrive, 0.62, 3), 4);
  EXPECT_EQ(unfitted_harmonic(4 * kDrive, kDrive, 0.63, 3), 0) << "by chance in more than one of 20 cases";
}

}  // namespace
}  // namespace dwell
