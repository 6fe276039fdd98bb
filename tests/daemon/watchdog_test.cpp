#include "daemon/watchdog.hpp"

#include <gtest/gtest.h>

#include "tests/durations.hpp"

namespace dwell {
namespace {

TEST(Watchdog, IsContentWhileEveryThreadTurnsAndEveryRingMoves) {
  Watchdog watchdog;
  for (std::int64_t s = 0; s < 60; ++s) {
    const std::int64_t now = s * kSecond_ns;
    const auto moved = static_cast<std::uint64_t>(s) * 1000;
    EXPECT_EQ(watchdog.judge(now, {{"estimate", now - kSecond_ns / 10, kSecond_ns}}, {{"amplifier", moved + 5, moved}}),
              "");
  }
}

TEST(Watchdog, NamesTheThreadThatHasNotTurnedWithinItsBound) {
  Watchdog watchdog;
  const std::vector<WatchedThread> threads{{"estimate", 0, 2 * kSecond_ns}, {"amplifier", 0, 5 * kSecond_ns}};
  EXPECT_EQ(watchdog.judge(2 * kSecond_ns, threads, {}), "");
  EXPECT_EQ(watchdog.judge(3 * kSecond_ns, threads, {}), "thread estimate has not turned for 3.0 s");
  EXPECT_NE(watchdog.judge(6 * kSecond_ns, threads, {}).find("amplifier"), std::string::npos);
}

TEST(Watchdog, ADriverThatHangsIsNoReasonToRestart) {
  Watchdog watchdog;
  EXPECT_EQ(watchdog.judge(60 * kSecond_ns, {{"amplifier", 0, 3 * kSecond_ns, false}}, {}), "");
}

TEST(Watchdog, NoticesSamplesThatNobodyTakes) {
  Watchdog watchdog;
  EXPECT_EQ(watchdog.judge(0, {}, {{"amplifier", 100, 60}}), "");
  EXPECT_EQ(watchdog.judge(2 * kSecond_ns, {}, {{"amplifier", 200, 60}}), "");
  EXPECT_EQ(watchdog.judge(3 * kSecond_ns, {}, {{"amplifier", 300, 60}}),
            "240 samples of amplifier are not taken for 3.0 s");
  EXPECT_EQ(watchdog.judge(4 * kSecond_ns, {}, {{"amplifier", 301, 61}}), "") << "one taken is progress";
}

TEST(Watchdog, AnEmptyRingMayRestForEver) {
  Watchdog watchdog;
  EXPECT_EQ(watchdog.judge(0, {}, {{"amplifier", 100, 100}}), "");
  EXPECT_EQ(watchdog.judge(3600 * kSecond_ns, {}, {{"amplifier", 100, 100}}), "");
  EXPECT_EQ(watchdog.judge(3601 * kSecond_ns, {}, {{"amplifier", 120, 100}}), "")
      << "samples that have only just come are not stuck";
}

}  // namespace
}  // namespace dwell
