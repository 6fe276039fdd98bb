#include "core/stream/held_arrivals.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

TEST(HeldArrivals, ReadingsComeOutInTheirOrderAndOnlyOnceDecided) {
  HeldArrivals held;
  DeviceInstant out;
  for (std::int64_t t = 1; t <= 3; ++t) held.add(t);
  EXPECT_FALSE(held.take(out)) << "none is decided";
  held.decide({10, 1, false});
  held.decide({20, 2, true});
  EXPECT_EQ(held.waiting(), 1u);
  EXPECT_EQ(held.arrival_ns(0), 3);
  ASSERT_TRUE(held.take(out));
  EXPECT_EQ(out.t_ns, 10);
  ASSERT_TRUE(held.take(out));
  EXPECT_EQ(out.t_ns, 20);
  EXPECT_EQ(out.half_ns, 2u);
  EXPECT_TRUE(out.after_loss);
  EXPECT_FALSE(held.take(out));
  EXPECT_EQ(held.waiting(), 1u);
}

TEST(HeldArrivals, IsFullWithItsCapacityDecidedOrNot) {
  HeldArrivals held;
  for (std::size_t i = 0; i < HeldArrivals::kCapacity; ++i) {
    EXPECT_FALSE(held.full());
    held.add(static_cast<std::int64_t>(i));
  }
  EXPECT_TRUE(held.full());
  held.decide({});
  EXPECT_TRUE(held.full()) << "decided, and not taken yet";
  DeviceInstant out;
  ASSERT_TRUE(held.take(out));
  EXPECT_FALSE(held.full());
}

TEST(HeldArrivals, GoesRoundItsRing) {
  HeldArrivals held;
  DeviceInstant out;
  std::int64_t taken = 0;
  for (std::int64_t t = 0; t < 2000; ++t) {
    held.add(t);
    if (held.waiting() < 100) continue;
    EXPECT_EQ(held.arrival_ns(0), taken);
    EXPECT_EQ(held.arrival_ns(99), t);
    held.decide({held.arrival_ns(0), 0, false});
    ASSERT_TRUE(held.take(out));
    ASSERT_EQ(out.t_ns, taken++);
  }
  EXPECT_EQ(taken, 1901);
}

}  // namespace
}  // namespace dwell
