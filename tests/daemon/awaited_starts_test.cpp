#include "daemon/run/awaited_starts.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dwell {
namespace {

constexpr std::int64_t kLate_ns = AwaitedStarts::kPatience_ns;

struct AwaitedStartsTest : testing::Test {
  void ask(std::uint16_t number, std::int64_t now_ns = 0) {
    starts.add(number, now_ns, [this, number](const StartOutcome& outcome) {
      const char* const is = outcome.is == StartOutcome::Is::recorded       ? " recorded"
                             : outcome.is == StartOutcome::Is::not_recorded ? " not recorded: "
                                                                            : " unknown";
      told.push_back(std::to_string(number) + is + outcome.why);
    });
  }
  // What is told where the recorder's newest start is this.
  std::vector<std::string> look(std::uint16_t newest, const char* obstacle = "", std::int64_t now_ns = 0,
                                bool ended = false) {
    record::RecorderState state;
    state.newest_start = newest;
    state.recording = *obstacle == '\0' && !ended;
    state.obstacle.why = obstacle;
    told.clear();
    starts.look(state, now_ns);
    return told;
  }
  using Told = std::vector<std::string>;

  AwaitedStarts starts;
  Told told;
};

TEST_F(AwaitedStartsTest, IsToldOnceTheRecorderHasTheRun) {
  ask(7);
  EXPECT_EQ(look(0), Told{});
  EXPECT_EQ(look(7), Told{"7 recorded"});
  EXPECT_EQ(look(7), Told{}) << "once";
}

TEST_F(AwaitedStartsTest, IsToldWhyTheRunIsNotRecorded) {
  ask(7);
  EXPECT_EQ(look(6, "disk full"), Told{}) << "that is of an earlier run";
  EXPECT_EQ(look(7, "disk full"), Told{"7 not recorded: disk full"});
}

TEST_F(AwaitedStartsTest, WaitsNoLongerThanItsPatience) {
  ask(7, 10);
  EXPECT_EQ(look(6, "", kLate_ns + 9), Told{});
  EXPECT_EQ(look(6, "", kLate_ns + 10), Told{"7 unknown"});
}

TEST_F(AwaitedStartsTest, OfARunThatIsOverAlreadyNothingIsKnown) {
  ask(65535);
  ask(2);
  ask(4);
  EXPECT_EQ(look(2, "disk full"), (Told{"65535 unknown", "2 not recorded: disk full"}))
      << "another run came after the first";
  EXPECT_EQ(look(4, "", 0, true), Told{"4 unknown"}) << "it was stopped at once";
}

}  // namespace
}  // namespace dwell
