// The live stream as an outlet: what is pushed, and when.
#include <gtest/gtest.h>

#include <optional>

#include "daemon/outlets/http.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

struct HttpOutletTest : testing::Test {
  HttpOutletTest() {
    snapshot.dwell.state = State::settling;
    HttpOptions options;
    options.port = 0;
    auto made = Http::make(loop, options, [this] { return view(); });
    EXPECT_TRUE(made) << made.error().message;
    http = std::move(*made);
    thread.emplace(loop);
  }
  [[nodiscard]] ServiceView view() const {
    ServiceView now{rig, run, snapshot};
    now.now_ns = snapshot.t_ns;
    if (http) now.http = http->server().stats();
    return now;
  }
  // A snapshot so many tenths of a second after the first, shown twice.
  void show(std::uint64_t sequence) {
    thread->on_loop([&] {
      snapshot.sequence = sequence;
      snapshot.t_ns = static_cast<std::int64_t>(sequence) * 100'000'000;
      http->show(view());
      http->show(view());
      return 0;
    });
  }

  Rig rig;
  RunInfo run;
  Snapshot snapshot;
  EventLoop loop;
  std::unique_ptr<Http> http;
  std::optional<test::LoopThread> thread;
};

TEST_F(HttpOutletTest, PushesEachSnapshotOnceAndANewcomerIsGivenAll) {
  show(1);  // nobody listens
  test::Client client = test::Client::tcp(http->server().port());
  client.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  client.until("\r\n\r\n");
  EXPECT_EQ(client.until("\n\n"), "retry: 1000\n\n");
  EXPECT_EQ(client.until("\n").substr(0, 12), "event: dwell");
  client.until("\n\n");
  std::string names;
  for (std::uint64_t sequence = 2; sequence <= 14; ++sequence) {
    show(sequence);
    names += client.until("\n").substr(7, 1);
    client.until("\n\n");
  }
  EXPECT_EQ(names, "dcccccccccdcc") << "whole at first and once a second";
  thread.reset();
}

TEST_F(HttpOutletTest, AnswersFromHowTheServiceStandsAtThatMoment) {
  test::Client client = test::Client::tcp(http->server().port());
  client.send("GET /api/v1/dwell HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_NE(client.until("\"settling\"").find("200 OK"), std::string::npos);
  thread.reset();
}

}  // namespace
}  // namespace dwell
