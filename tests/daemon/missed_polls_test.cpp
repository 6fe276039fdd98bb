#include "daemon/estimate/missed_polls.hpp"

#include <gtest/gtest.h>

#include "tests/durations.hpp"

namespace dwell {
namespace {

// As seen of a healthy rig: 11697 polls of 500 a second skipped in two hours.
TEST(MissedPolls, AFewInAThousandAreNoNews) {
  MissedPolls polls;
  for (std::int64_t s = 0; s <= 7200; ++s)
    EXPECT_FALSE(polls.look(s * kSecond_ns, static_cast<std::uint64_t>(s * 11697 / 7200), 500.0));
}

TEST(MissedPolls, ARateThatIsNeverReachedIsToldOnceAMinuteWithThePart) {
  MissedPolls polls;
  int told = 0;
  for (std::int64_t s = 0; s <= 600; ++s)
    if (const auto part = polls.look(s * kSecond_ns, static_cast<std::uint64_t>(s) * 150, 500.0)) {
      ++told;
      EXPECT_NEAR(*part, 0.3, 1e-3);
    }
  EXPECT_EQ(told, 10);
}

TEST(MissedPolls, WithoutAKnownRateNothingIsSaid) {
  MissedPolls polls;
  for (std::int64_t s = 0; s <= 600; ++s)
    EXPECT_FALSE(polls.look(s * kSecond_ns, static_cast<std::uint64_t>(s) * 150, 0.0));
}

}  // namespace
}  // namespace dwell
