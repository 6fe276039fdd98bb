#include "daemon/log/throttle.hpp"

#include <gtest/gtest.h>

#include "tests/durations.hpp"

namespace dwell {
namespace {

TEST(Throttle, LetsTheFirstOneThroughAtOnce) {
  Throttle throttle;
  EXPECT_EQ(throttle.admit(0), 1u);
}

TEST(Throttle, NeverSpeaksMoreThanOnceASecond) {
  Throttle throttle;
  std::int64_t last_ns = -1'000'000 * kMs_ns;
  for (std::int64_t now_ns = 0; now_ns < 300'000 * kMs_ns; now_ns += 7 * kMs_ns) {
    if (!throttle.admit(now_ns)) continue;
    EXPECT_GE(now_ns - last_ns, 1000 * kMs_ns);
    last_ns = now_ns;
  }
}

TEST(Throttle, AccountsForEveryOccurrence) {
  Throttle throttle;
  std::uint64_t told = 0;
  std::uint64_t lines = 0;
  for (std::int64_t i = 0; i < 100'000; ++i) {
    if (const auto stands_for = throttle.admit(i * 3 * kMs_ns)) {
      told += *stands_for;
      ++lines;
    }
  }
  if (const auto rest = throttle.admit(100'000 * 3 * kMs_ns + 61'000 * kMs_ns, 0)) told += *rest;
  EXPECT_EQ(told, 100'000u);
  EXPECT_LT(lines, 15u) << "what goes on for five minutes is told ever more rarely";
}

TEST(Throttle, StartsAnewAfterAQuietMinute) {
  Throttle throttle;
  std::int64_t now_ns = 0;
  for (; now_ns < 100'000 * kMs_ns; now_ns += 100 * kMs_ns) (void)throttle.admit(now_ns);
  now_ns += 61'000 * kMs_ns;
  EXPECT_TRUE(throttle.admit(now_ns).has_value());
  EXPECT_FALSE(throttle.admit(now_ns + 500 * kMs_ns).has_value());
  EXPECT_EQ(throttle.admit(now_ns + 1100 * kMs_ns), 2u);
}

}  // namespace
}  // namespace dwell
