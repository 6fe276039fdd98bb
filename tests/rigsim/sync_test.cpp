#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "tests/rigsim/sync_pulses.hpp"

namespace rigsim {
namespace {

// A pipe takes the place of the simulated line.
struct SyncTest : testing::Test {
  SyncTest() {
    EXPECT_EQ(::pipe(ends), 0);
    Options rig;
    rig.drive.frequency_hz = 100.0;
    server = std::move(*Server::start(rig));
    options.file = "/proc/self/fd/" + std::to_string(ends[1]);
  }
  ~SyncTest() override {
    pulses.reset();
    ::close(ends[0]);
    ::close(ends[1]);
  }
  // The next words that the line is told.
  std::string told(std::size_t bytes) {
    std::string all;
    pollfd ready{ends[0], POLLIN, 0};
    while (all.size() < bytes && ::poll(&ready, 1, 20'000) == 1) {
      char chunk[64];
      const auto size = ::read(ends[0], chunk, std::min(sizeof chunk, bytes - all.size()));
      if (size <= 0) break;
      all.append(chunk, static_cast<std::size_t>(size));
    }
    return all;
  }

  int ends[2] = {-1, -1};
  std::unique_ptr<Server> server;
  SyncOptions options;
  std::unique_ptr<SyncPulses> pulses;
};

TEST_F(SyncTest, PulsesGoUpAndDownWhileTheDriveRuns) {
  pulses = std::move(*SyncPulses::start(options, *server));
  EXPECT_EQ(told(36), "pull-up\npull-down\npull-up\npull-down\n");
}

TEST_F(SyncTest, AStoppedDriveHasNone) {
  server->command("stop");
  options.missing = 0.0;
  pulses = std::move(*SyncPulses::start(options, *server));
  server->command("status");
  pulses.reset();
  pollfd ready{ends[0], POLLIN, 0};
  EXPECT_EQ(::poll(&ready, 1, 0), 0);
}

TEST_F(SyncTest, AFileThatCannotBeWrittenIsSaidToBe) {
  options.file = "/no/such/line";
  const auto none = SyncPulses::start(options, *server);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error(), "cannot write /no/such/line: No such file or directory");
}

TEST(RunningFrequency, IsReadFromTheStatusLine) {
  auto server = std::move(*Server::start({}));
  EXPECT_EQ(running_frequency_hz(server->command("status")), 4.0);
  server->command("frequency 4.25");
  EXPECT_EQ(running_frequency_hz(server->command("status")), 4.25);
  server->command("stop");
  EXPECT_EQ(running_frequency_hz(server->command("status")), 0.0);
  EXPECT_EQ(running_frequency_hz("error: what?"), 0.0);
}

}  // namespace
}  // namespace rigsim
