#include "daemon/notifier.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "daemon/outlets/outlet.hpp"

namespace dwell {
namespace {

// Plays systemd: a datagram socket in NOTIFY_SOCKET.
struct NotifierTest : testing::Test {
  void SetUp() override {
    path = "/tmp/dwell-notify-" + std::to_string(getpid());
    unlink(path.c_str());
    descriptor = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    ASSERT_EQ(bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  void TearDown() override {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
    close(descriptor);
    unlink(path.c_str());
  }
  std::string received() {
    char text[512];
    const auto size = recv(descriptor, text, sizeof text, 0);
    return size < 0 ? std::string() : std::string(text, static_cast<std::size_t>(size));
  }
  std::string path;
  int descriptor = -1;
};

TEST_F(NotifierTest, SaysReadyStoppingAndAlive) {
  const Notifier notifier;
  notifier.ready();
  EXPECT_EQ(received(), "READY=1");
  notifier.feed_watchdog();
  EXPECT_EQ(received(), "WATCHDOG=1");
  notifier.stopping();
  EXPECT_EQ(received().substr(0, 10), "STOPPING=1");
}

TEST_F(NotifierTest, SendsAStatusOnlyWhenItChanges) {
  Notifier notifier;
  notifier.status("settling, dwell 1");
  EXPECT_EQ(received(), "STATUS=settling, dwell 1");
  notifier.status("settling, dwell 1");
  EXPECT_EQ(received(), "");
  notifier.status("a\nREADY=1");
  EXPECT_EQ(received(), "STATUS=a READY=1") << "one assignment, whatever the text holds";
}

TEST_F(NotifierTest, KnowsHowOftenTheWatchdogWantsToBeFed) {
  EXPECT_EQ(Notifier().watchdog_ms(), 0);
  setenv("WATCHDOG_USEC", "10000000", 1);
  EXPECT_EQ(Notifier().watchdog_ms(), 10'000);
  setenv("WATCHDOG_PID", "1", 1);
  EXPECT_EQ(Notifier().watchdog_ms(), 0) << "meant for another process";
}

TEST(Notifier, DoesNothingWhereNobodyAsked) {
  unsetenv("NOTIFY_SOCKET");
  Notifier notifier;
  notifier.ready();
  notifier.status("x");
  notifier.feed_watchdog();
}

TEST_F(NotifierTest, TheStatusLineTellsTheDwellAndWhatIsWrong) {
  Notifier notifier;
  const auto outlet = make_systemd_status(notifier);
  const Rig rig;
  const RunInfo run;
  Snapshot snapshot;
  snapshot.dwell.index = 3;
  snapshot.dwell.state = State::measuring;
  snapshot.dwell.frequency_hz.value = 4.0003;
  ServiceView now{rig, run, snapshot};
  outlet->show(now);
  EXPECT_EQ(received(), "STATUS=measuring, dwell 3, 4 Hz");
  now.health = {Health::Status::degraded, {{"channel:y0", "channel y0: timeout"}}, false};
  outlet->show(now);
  EXPECT_EQ(received(), "STATUS=measuring, dwell 3, 4 Hz; channel y0: timeout");
  now.health = {Health::Status::fault, {{"service", "thread estimate has not turned for 3.0 s"}}, false};
  outlet->show(now);
  EXPECT_EQ(received(), "STATUS=not working: thread estimate has not turned for 3.0 s");
}

}  // namespace
}  // namespace dwell
