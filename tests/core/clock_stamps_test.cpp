#include "core/stream/clock_stamps.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

TEST(ClockStamps, AnArrivalThatStandsHasNoWidth) {
  ClockStamps stamps;
  const DeviceInstant instant = stamps.arrived(5'000);
  EXPECT_EQ(instant.t_ns, 5'000);
  EXPECT_EQ(instant.half_ns, 0u);
  EXPECT_FALSE(instant.after_loss);
}

TEST(ClockStamps, EachLiesAfterTheOneBeforeAndIsAsWideAsItWasMoved) {
  ClockStamps stamps;
  stamps.arrived(5'000);
  stamps.begin();
  const DeviceInstant forced = stamps.recovered(4'000, 10.0, 1'600.0);
  EXPECT_EQ(forced.t_ns, 5'100) << "a sixteenth of a period later";
  EXPECT_EQ(forced.half_ns, 1'110u);
  const DeviceInstant free = stamps.recovered(6'600, 10.0, 1'600.0);
  EXPECT_EQ(free.t_ns, 6'600);
  EXPECT_EQ(free.half_ns, 10u);
}

TEST(ClockStamps, ALossIsMarkedAtTheNextStampAlone) {
  ClockStamps stamps;
  stamps.lost();
  EXPECT_TRUE(stamps.recovered(1'000, 1.0, 1'000.0).after_loss);
  EXPECT_FALSE(stamps.recovered(2'000, 1.0, 1'000.0).after_loss);
}

TEST(ClockStamps, ADoubtAboutTheNumberingWidensTheNextStampAlone) {
  ClockStamps stamps;
  stamps.doubt(2.0);
  EXPECT_EQ(stamps.recovered(1'000, 1.0, 1'000.0).half_ns, 2'001u);
  EXPECT_EQ(stamps.recovered(2'000, 1.0, 1'000.0).half_ns, 1u);
}

TEST(ClockStamps, AClockFoundAnewHasLostNothingYet) {
  ClockStamps stamps;
  stamps.lost();
  stamps.doubt(1.0);
  stamps.begin();
  const DeviceInstant instant = stamps.recovered(1'000, 1.0, 1'000.0);
  EXPECT_FALSE(instant.after_loss);
  EXPECT_EQ(instant.half_ns, 1u);
}

}  // namespace
}  // namespace dwell
