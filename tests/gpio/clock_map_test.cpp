#include "daemon/gpio/clock_map.hpp"

#include <gtest/gtest.h>

namespace dwell::gpio {
namespace {

TEST(ClockMap, CarriesTheOffsetOfOnePairEverywhere) {
  ClockMap map;
  map.add({1'000'000, 400'000, 20});
  EXPECT_EQ(map.raw_ns(400'000), 1'000'000);
  EXPECT_EQ(map.raw_ns(399'000), 999'000);
}

TEST(ClockMap, IsExactBetweenTwoPairsThoughTheClocksDriftApart) {
  // MONOTONIC is slewed by 500 ppm: ten seconds of RAW are 10.005 of it.
  ClockMap map;
  map.add({5'000'000'000, 1'000'000'000, 20});
  map.add({15'000'000'000, 11'005'000'000, 20});
  EXPECT_NEAR(static_cast<double>(map.raw_ns(6'002'500'000) - 10'000'000'000), 0.0, 2.0);
  EXPECT_EQ(map.raw_ns(1'000'000'000), 5'000'000'000);
  EXPECT_EQ(map.raw_ns(11'005'000'000), 15'000'000'000);
}

TEST(ClockMap, UsesTheNearerPairOutside) {
  ClockMap map;
  map.add({5'000, 1'000, 0});
  map.add({15'000, 11'100, 0});
  EXPECT_EQ(map.raw_ns(900), 4'900);
  EXPECT_EQ(map.raw_ns(11'200), 15'100);
}

TEST(ClockMap, RealPairsAreNarrowAndInOrder) {
  const ClockPair first = read_clock_pair();
  const ClockPair second = read_clock_pair();
  EXPECT_GE(first.half_ns, 0);
  EXPECT_GT(second.raw_ns, first.raw_ns);
  EXPECT_GT(second.monotonic_ns, first.monotonic_ns);
}

}  // namespace
}  // namespace dwell::gpio
