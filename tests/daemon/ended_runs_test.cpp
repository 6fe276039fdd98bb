// Which runs operators have ended, before the snapshot shows it.
#include "daemon/run/ended_runs.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

RunView seen(std::uint32_t number, bool on) {
  RunView run;
  run.number = number;
  run.on = on;
  return run;
}

TEST(EndedRuns, ARunThatWasStoppedDoesNotGoOnThoughTheSnapshotStillShowsIt) {
  EndedRuns ended;
  EXPECT_TRUE(ended.goes_on(seen(3, true)));
  ended.stopped(seen(3, true));
  EXPECT_FALSE(ended.goes_on(seen(3, true)));
  EXPECT_FALSE(ended.goes_on(seen(3, false)));
  EXPECT_TRUE(ended.goes_on(seen(4, true))) << "another has begun";
}

TEST(EndedRuns, ARunThatWasStartedAndStoppedBeforeItIsSeenHasEnded) {
  EndedRuns ended;
  ended.started(seen(3, true));
  ended.stopped(seen(3, true));
  EXPECT_FALSE(ended.goes_on(seen(3, true))) << "the start ended it";
  EXPECT_FALSE(ended.goes_on(seen(4, true))) << "this is the one that was stopped";
  EXPECT_TRUE(ended.goes_on(seen(5, true)));
}

}  // namespace
}  // namespace dwell
