#include "daemon/serve/control_server.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <semaphore>
#include <thread>

#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

using test::Client;

struct ControlServerTest : testing::Test {
  void SetUp() override {
    char name[] = "/tmp/dwell-control-XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder = name;
    options.path = folder + "/control";
  }
  void TearDown() override {
    thread.reset();
    server.reset();
    std::filesystem::remove_all(folder);
  }
  void begin() {
    auto made = ControlServer::make(loop, options, answer);
    ASSERT_TRUE(made) << made.error();
    server = std::move(*made);
    thread.emplace(loop);
  }
  static std::string answer(std::string_view line, const Peer& peer) {
    if (line == "throw") throw std::runtime_error("no");
    return std::string(line) + (peer.uid == getuid() && peer.pid == getpid() ? "!" : "?");
  }

  EventLoop loop;
  std::string folder;
  ControlOptions options;
  std::unique_ptr<ControlServer> server;
  std::optional<test::LoopThread> thread;
};

TEST_F(ControlServerTest, AnswersLineByLineAndKnowsWhoAsks) {
  begin();
  Client client = Client::local(options.path);
  client.send("one\ntwo\r\nthree");
  EXPECT_EQ(client.until("\n"), "one!\n");
  EXPECT_EQ(client.until("\n"), "two!\n");
  client.send(" and a half\n");
  EXPECT_EQ(client.until("\n"), "three and a half!\n");
}

// A caller has sent two lines at once. Between them another one ends the server, and with it what its handler uses.
TEST_F(ControlServerTest, ALineThatLiesThereAsTheServerEndsIsNotHandedOn) {
  int handed_on = 0;
  auto made = ControlServer::make(loop, options, [&](std::string_view line, const Peer&) {
    ++handed_on;
    if (line == "end") server.reset();
    return ControlReply(std::string());
  });
  ASSERT_TRUE(made) << made.error();
  server = std::move(*made);
  const Client two = Client::local(options.path), end = Client::local(options.path);
  loop.context().poll();
  two.send("one\ntwo\n");
  end.send("end\n");
  while (server) loop.context().poll();
  loop.context().poll();
  EXPECT_EQ(handed_on, 2);
}

// The line and the end of the caller's time are seen in one turn of the loop.
TEST_F(ControlServerTest, WhoAsksInTheLastMomentIsAnswered) {
  options.idle_time = std::chrono::milliseconds(20);
  auto made = ControlServer::make(loop, options, answer);
  ASSERT_TRUE(made) << made.error();
  server = std::move(*made);
  Client client = Client::local(options.path);
  loop.context().poll();
  const auto over = std::chrono::steady_clock::now() + options.idle_time;
  client.send("one\n");
  while (std::chrono::steady_clock::now() <= over) std::this_thread::yield();
  loop.context().poll();
  EXPECT_EQ(client.until("\n"), "one!\n");
  client.send("two\n");
  loop.context().poll();
  EXPECT_EQ(client.until("\n"), "two!\n") << "and may go on";
}

TEST_F(ControlServerTest, OnlyOwnerAndGroupMayUseIt) {
  const mode_t before = umask(0);
  begin();
  umask(before);
  struct stat is {};
  ASSERT_EQ(stat(options.path.c_str(), &is), 0);
  EXPECT_EQ(is.st_mode & 0777u, 0660u);
}

TEST_F(ControlServerTest, ALineWithoutEndIsCutOff) {
  begin();
  Client client = Client::local(options.path);
  client.send(std::string(100'000, 'a'));
  EXPECT_EQ(client.until("\n"), "{\"error\":\"the request has more bytes than a line may have, which is " +
                                    std::to_string(options.line_bytes) + "\"}\n");
  EXPECT_EQ(client.all(), "");
}

TEST_F(ControlServerTest, AnAnswerThatCannotBeMadeIsAnErrorAndNothingMore) {
  begin();
  Client client = Client::local(options.path);
  client.send("throw\nand on\n");
  EXPECT_EQ(client.until("\n"), "{\"error\":\"the answer could not be made\"}\n");
  EXPECT_EQ(client.until("\n"), "and on!\n");
}

TEST_F(ControlServerTest, ACallerThatSaysNothingIsLetGo) {
  options.idle_time = std::chrono::milliseconds(100);
  begin();
  Client client = Client::local(options.path);
  client.send("half a li");
  EXPECT_EQ(client.all(), "");
}

// A server whose answer to "slow" is given by hand, on the loop's thread.
struct SlowAnswers : ControlServerTest {
  void begin() {
    auto made = ControlServer::make(loop, options, [this](std::string_view line, const Peer& peer) {
      if (line != "slow") return ControlReply(answer(line, peer));
      return ControlReply([this](ControlReply::Answer way) {
        slow = std::move(way);
        asked.release();
      });
    });
    ASSERT_TRUE(made) << made.error();
    server = std::move(*made);
    thread.emplace(loop);
  }
  // Returns once the server has the question.
  void ask(Client& client) {
    client.send("slow\n");
    asked.acquire();
  }
  ControlReply::Answer slow;
  std::binary_semaphore asked{0};
};

TEST_F(SlowAnswers, HoldUpNoOtherCallerAndKeepTheOrderOfTheirOwn) {
  begin();
  Client patient = Client::local(options.path);
  ask(patient);
  patient.send("next\n");
  Client other = Client::local(options.path);
  other.send("x\n");
  EXPECT_EQ(other.until("\n"), "x!\n");
  loop.post([this] { slow("at last"); });
  EXPECT_EQ(patient.until("\n"), "at last\n");
  EXPECT_EQ(patient.until("\n"), "next!\n");
}

TEST_F(SlowAnswers, AreAwaitedLongerThanACallerMayBeIdle) {
  options.idle_time = std::chrono::seconds(1);  // enough to connect and ask on a machine that is busy
  begin();
  Client patient = Client::local(options.path);
  ask(patient);
  Client idle = Client::local(options.path);
  EXPECT_EQ(idle.all(), "");  // let go after the idle time
  loop.post([this] { slow("at last"); });
  EXPECT_EQ(patient.until("\n"), "at last\n");
}

TEST_F(SlowAnswers, MayComeAfterTheCallerOrTheServerHasGone) {
  begin();
  {
    Client hasty = Client::local(options.path);
    ask(hasty);
  }
  loop.post([this] { slow("for nobody"); });
  Client waiting = Client::local(options.path);
  ask(waiting);
  thread.reset();
  server.reset();
  slow("for nobody");
  EXPECT_EQ(waiting.all(), "");
}

TEST_F(ControlServerTest, TooManyCallersAreTurnedAway) {
  options.clients = 2;
  begin();
  Client first = Client::local(options.path);
  Client second = Client::local(options.path);
  first.send("x\n");
  ASSERT_EQ(first.until("\n"), "x!\n");
  second.send("x\n");
  ASSERT_EQ(second.until("\n"), "x!\n");
  Client third = Client::local(options.path);
  third.send("x\n");
  EXPECT_EQ(third.all(), "");
}

TEST_F(ControlServerTest, CallersThatAskNothingMakeRoomForOneThatDoes) {
  options.clients = 2;
  begin();
  Client first = Client::local(options.path);
  first.send("x\n");
  ASSERT_EQ(first.until("\n"), "x!\n");
  Client silent = Client::local(options.path);
  silent.send("never a whole line");
  Client third = Client::local(options.path);
  third.send("x\n");
  EXPECT_EQ(third.until("\n"), "x!\n");
  EXPECT_EQ(silent.all(), "");
  first.send("y\n");
  EXPECT_EQ(first.until("\n"), "y!\n");
}

TEST_F(ControlServerTest, ReplacesWhatADeadProcessLeftBehind) {
  const int left = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, options.path.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(left);
  begin();
  Client client = Client::local(options.path);
  client.send("x\n");
  EXPECT_EQ(client.until("\n"), "x!\n");
}

TEST_F(ControlServerTest, TakesNothingFromOneThatLives) {
  begin();
  EventLoop other;
  const auto second = ControlServer::make(other, options, answer);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().find("another dwelld"), std::string::npos) << second.error();
}

TEST_F(ControlServerTest, TouchesNoFileThatIsNoSocket) {
  std::ofstream(options.path) << "precious";
  const auto made = ControlServer::make(loop, options, answer);
  ASSERT_FALSE(made);
  EXPECT_TRUE(std::filesystem::is_regular_file(options.path));
}

TEST_F(ControlServerTest, APathTooLongForTheKernelIsAnErrorInWords) {
  options.path = folder + "/" + std::string(200, 'x');
  const auto made = ControlServer::make(loop, options, answer);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().find("too long"), std::string::npos);
}

TEST_F(ControlServerTest, RemovesItsSocketInTheEnd) {
  begin();
  thread.reset();
  server.reset();
  EXPECT_FALSE(std::filesystem::exists(options.path));
}

}  // namespace
}  // namespace dwell
