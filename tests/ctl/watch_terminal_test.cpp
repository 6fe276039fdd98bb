// watch on a real (pseudo) terminal: what it writes, what it obeys, and that the terminal comes back as it was.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/report/dwell_json.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/sample_text.hpp"
#include "tests/ctl/scripted_server.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell {
namespace {

using test::dwell_event;
using test::Reply;
using test::sample_text;
using test::ScriptedServer;

constexpr const char* kEnter = "\x1b[?1049h";
constexpr const char* kLeave = "\x1b[?25h\x1b[?1049l";

// dwellctl with a pseudo terminal of 24 x 80 as its controlling one; this side is the operator's.
class OnTerminal {
 public:
  explicit OnTerminal(std::vector<std::string> arguments, const char* kind = "xterm", const char* no_color = "") {
    arguments.insert(arguments.begin(), DWELLCTL);
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    winsize size{24, 80, 0, 0};
    process_ = ::forkpty(&terminal_, nullptr, nullptr, &size);
    if (process_ < 0) throw std::runtime_error("no pseudo terminal");
    if (process_ == 0) {
      ::setenv("TERM", kind, 1);
      ::setenv("NO_COLOR", no_color, 1);
      ::execv(DWELLCTL, pointers.data());
      _exit(98);
    }
    ::tcgetattr(terminal_, &before_);
  }
  ~OnTerminal() {
    if (process_ > 0) {
      ::kill(process_, SIGKILL);
      ::waitpid(process_, nullptr, 0);
    }
    ::close(terminal_);
  }
  OnTerminal(const OnTerminal&) = delete;
  OnTerminal& operator=(const OnTerminal&) = delete;

  // Reads until the text has been written; false: it never was. watch goes on to write, so silence alone is no end.
  bool await(const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (out_.find(text) == std::string::npos)
      if (!read() || std::chrono::steady_clock::now() > deadline) return false;
    return true;
  }
  // Forgets what was written so far.
  void forget() { out_.clear(); }
  void type(const std::string& keys) const {
    ASSERT_EQ(::write(terminal_, keys.data(), keys.size()), ssize_t(keys.size()));
  }
  void send(int signal) const { ::kill(process_, signal); }
  void resize(unsigned short rows, unsigned short columns) const {
    winsize size{rows, columns, 0, 0};
    ::ioctl(terminal_, TIOCSWINSZ, &size);
  }
  // Whether it stops, as by Ctrl-Z.
  [[nodiscard]] bool stops() const {
    int status = 0;
    return ::waitpid(process_, &status, WUNTRACED) == process_ && WIFSTOPPED(status);
  }
  // Until it has ended: its status as waitpid tells it.
  int end() {
    // The terminal's settings can be asked for until this side is closed.
    while (read()) {
    }
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return status;
  }
  [[nodiscard]] const std::string& out() const { return out_; }
  [[nodiscard]] bool as_before() const {
    termios now{};
    ::tcgetattr(terminal_, &now);
    return now.c_lflag == before_.c_lflag && now.c_iflag == before_.c_iflag && now.c_oflag == before_.c_oflag &&
           std::memcmp(now.c_cc, before_.c_cc, sizeof now.c_cc) == 0;
  }
  [[nodiscard]] bool echoes() const {
    termios now{};
    ::tcgetattr(terminal_, &now);
    return (now.c_lflag & ECHO) != 0;
  }

 private:
  bool read() {
    pollfd look{terminal_, POLLIN, 0};
    if (::poll(&look, 1, 30'000) <= 0) return false;
    std::array<char, 4096> buffer{};
    const ssize_t got = ::read(terminal_, buffer.data(), buffer.size());  // EIO: the other side has gone
    if (got <= 0) return false;
    out_.append(buffer.data(), static_cast<std::size_t>(got));
    return true;
  }

  int terminal_ = -1;
  pid_t process_ = -1;
  termios before_{};
  std::string out_;
};

Reply measuring() { return {test::stream_header() + dwell_event(sample_text()), true}; }

TEST(WatchOnATerminal, TheKeyQEndsItAndTheTerminalComesBackWithTheLastNumbers) {
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("q quit")) << watch.out();
  EXPECT_NE(watch.out().find(kEnter), std::string::npos);
  EXPECT_FALSE(watch.echoes());
  watch.type("q");
  const int status = watch.end();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  const auto left = watch.out().find(kLeave);
  ASSERT_NE(left, std::string::npos);
  EXPECT_NE(watch.out().find("24.010 ±   0.027 kN/m", left), std::string::npos);
  EXPECT_TRUE(watch.as_before());
}

TEST(WatchOnATerminal, EverySignalGivesTheTerminalBack) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGABRT, SIGSEGV}) {
    ScriptedServer server({measuring()});
    OnTerminal watch({"watch", "--url", server.url()});
    ASSERT_TRUE(watch.await("q quit")) << watch.out();
    watch.send(signal);
    const int status = watch.end();
    const bool crash = signal == SIGABRT || signal == SIGSEGV;
    EXPECT_TRUE(crash ? WIFSIGNALED(status) && WTERMSIG(status) == signal
                      : WIFEXITED(status) && WEXITSTATUS(status) == 0)
        << strsignal(signal) << ' ' << status;
    EXPECT_NE(watch.out().find(kLeave), std::string::npos) << strsignal(signal);
    EXPECT_TRUE(watch.as_before()) << strsignal(signal);
  }
}

TEST(WatchOnATerminal, GivesTheTerminalBackBeforeItComplains) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(sample_text()) + dwell_event("{}"), true}});
  OnTerminal watch({"watch", "--url", server.url()});
  const int status = watch.end();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 3) << status;
  const auto left = watch.out().find(kLeave);
  ASSERT_NE(left, std::string::npos);
  EXPECT_NE(watch.out().find("what answers is not the service", left), std::string::npos);
  EXPECT_TRUE(watch.as_before());
}

TEST(WatchOnATerminal, AnotherSizeIsDrawnAtOnce) {
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("q quit")) << watch.out();
  watch.forget();
  watch.resize(12, 40);
  EXPECT_TRUE(watch.await("page 1 of ")) << watch.out();
  watch.forget();
  watch.type("n");
  EXPECT_TRUE(watch.await("page 2 of ")) << watch.out();
}

TEST(WatchOnATerminal, OfKeysTypedTogetherEachTurnsAPage) {
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("q quit")) << watch.out();
  watch.resize(12, 40);
  ASSERT_TRUE(watch.await("page 1 of 21")) << "drawn at the new size: " << watch.out();
  watch.type("nnn");
  EXPECT_TRUE(watch.await("page 4 of ")) << watch.out();
  watch.type("bb");
  EXPECT_TRUE(watch.await("page 2 of ")) << watch.out();
}

TEST(WatchOnATerminal, PauseHoldsTheNumbersAndGoesOn) {
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("q quit"));
  watch.type(" ");
  EXPECT_TRUE(watch.await("PAUSED"));
  watch.type(" ");
  watch.forget();
  EXPECT_TRUE(watch.await("space pause"));
}

// A stream, and what is asked for beside it a second later. The list of runs, which comes last, is left to the test.
std::vector<Reply> stream_and_dwells() {
  Reply stream = measuring();
  stream.hold = false;
  stream.beside = true;
  const std::string dwells =
      R"({"dwells":[{"index":1,"start_utc":"2026-11-23T06:00:00Z","settled_s":4200,"end_s":7140,)"
      R"("elements":[{"stiffness":{"value":24000},"damping":{"value":60}}]}]})";
  return {stream,
          {test::http_reply(200, R"({"channels":[]})")},
          {test::http_reply(200, R"({"alarms":[],"unacknowledged":0,"left_out":0})")},
          {test::http_reply(200, R"({"utc":"2026-11-23T08:00:00Z"})")},
          {test::http_reply(200, dwells)}};
}

TEST(WatchOnATerminal, TheTrendBeginsWithTheDwellsOfTheLastHour) {
  ScriptedServer server(stream_and_dwells());
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("trend of the last 50 min")) << watch.out();
  EXPECT_NE(server.requests().at(4).find("GET /api/v1/dwells?brief=1"), std::string::npos);
}

TEST(WatchOnATerminal, DwellsThatEndedWhileTheConnectionWasLostAreAskedFor) {
  std::vector<Reply> replies = stream_and_dwells();
  replies.front() = Reply{test::stream_header() + dwell_event(test::settling_text())};
  replies.front().beside = true;
  replies.back() = {test::http_reply(200, R"({"dwells":[]})"), false, false, false, true};
  replies.push_back({test::http_reply(200, R"({"runs":[]})")});
  for (const Reply& reply : stream_and_dwells()) replies.push_back(reply);
  ScriptedServer server(replies);
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("trend of the last 50 min")) << watch.out();
  EXPECT_NE(server.requests().at(10).find("GET /api/v1/dwells?brief=1"), std::string::npos);
}

TEST(WatchOnATerminal, AtAnIdleRigTheLastDwellAndSinceWhenAreAskedFor) {
  Dwell idle;
  idle.state = State::idle;
  std::vector<Reply> replies = stream_and_dwells();
  replies.front().text = test::stream_header() + dwell_event(to_json(idle, test::sample_rig(), test::sample_run()));
  replies.push_back(
      {test::http_reply(200, R"({"events":[{"utc":"2026-11-23T07:59:48Z","state":"idle","text":"the table rests"},)"
                             R"({"utc":"2026-11-23T07:59:50Z","state":null,"text":"run 3 ended"}]})")});
  Dwell last = test::sample_dwell();
  last.state = State::complete;
  last.ended_by = EndedBy::drive_stopped;
  replies.push_back(
      {test::http_reply(200, R"({"dwells":[)" + to_json(last, test::sample_rig(), test::sample_run()) + "]}")});
  ScriptedServer server(replies);
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("not of now")) << watch.out();
  EXPECT_TRUE(watch.await("drive stopped")) << watch.out();
  EXPECT_NE(watch.out().find("since "), std::string::npos) << watch.out();
  EXPECT_NE(server.requests().at(5).find("GET /api/v1/events"), std::string::npos);
  EXPECT_NE(server.requests().at(6).find("GET /api/v1/dwells?count=1"), std::string::npos);
}

TEST(WatchOnATerminal, RearmAsksFirstAndGoesThroughTheControlSocket) {
  const test::TemporaryFolder folder;
  ScriptedServer control({Reply{"{\"done\":true}\n", true}}, folder.path("control"));
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url(), "--control", folder.path("control")});
  ASSERT_TRUE(watch.await("r rearm"));
  watch.type("rn");
  ASSERT_TRUE(watch.await("not rearmed"));
  EXPECT_TRUE(control.requests().empty());
  watch.type("ry");
  ASSERT_TRUE(watch.await("rearmed at "));
  EXPECT_EQ(control.requests().at(0), R"({"verb":"rearm"})");
}

TEST(WatchOnATerminal, NumbersTurnOldWhenTheServiceGoes) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(sample_text())}});
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("NO CONNECTION")) << watch.out();
  EXPECT_TRUE(watch.await("last seen: dwell 1")) << watch.out();
  EXPECT_TRUE(watch.await("OLD NUMBERS")) << watch.out();
}

TEST(WatchOnATerminal, CtrlZGivesTheTerminalBackForAWhile) {
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url()});
  ASSERT_TRUE(watch.await("q quit"));
  watch.send(SIGTSTP);
  ASSERT_TRUE(watch.stops());
  EXPECT_TRUE(watch.await(kLeave));
  EXPECT_TRUE(watch.as_before());
  watch.forget();
  watch.send(SIGCONT);
  EXPECT_TRUE(watch.await(kEnter));
  EXPECT_TRUE(watch.await("q quit"));
  EXPECT_FALSE(watch.echoes());
}

TEST(WatchOnATerminal, WithoutColoursOldNumbersAreFaint) {
  for (const bool colour : {true, false}) {
    ScriptedServer server({Reply{test::stream_header() + dwell_event(sample_text())}});
    OnTerminal watch({"watch", "--url", server.url()}, "xterm", colour ? "" : "1");
    ASSERT_TRUE(watch.await("OLD NUMBERS"));
    ASSERT_TRUE(watch.await("q quit"));
    EXPECT_EQ(watch.out().find("\x1b[90;9m") != std::string::npos, colour);
    EXPECT_EQ(watch.out().find("\x1b[1;31m") != std::string::npos, colour);
  }
}

TEST(WatchOnATerminal, ADumbOneGetsLines) {
  ScriptedServer server({measuring()});
  OnTerminal watch({"watch", "--url", server.url(), "--until", "20"}, "dumb");
  const int status = watch.end();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_NE(watch.out().find("24.6 s of data"), std::string::npos);
  EXPECT_EQ(watch.out().find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace dwell
