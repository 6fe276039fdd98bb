#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "daemon/serve/http_request.hpp"
#include "daemon/serve/http_server.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

using test::Client;
using test::read_answer;

struct HttpStreamTest : testing::Test {
  void begin(HttpOptions options = {}) {
    options.port = 0;
    auto made = HttpServer::make(
        loop, options,
        [](const HttpRequest&) {
          return HttpReply{200, "{}"};
        },
        [](const HttpRequest& request) -> tl::expected<StreamBegin, HttpReply> {
          if (request.query() == "refused") return tl::unexpected(http_error(401, "not you"));
          return StreamBegin{event_text("dwell", "\"first\"")};
        });
    ASSERT_TRUE(made) << made.error().message;
    server = std::move(*made);
    port = server->port();
    thread.emplace(loop);
  }
  Client stream(int receive_buffer = 0) {
    Client client = Client::tcp(port, receive_buffer);
    client.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client;
  }
  Client asking(const std::string& query) {
    Client client = Client::tcp(port);
    client.send("GET /api/v1/stream?" + query + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client;
  }
  void broadcast(const std::string& data) {
    thread->on_loop([&] { server->broadcast("dwell", data); });
  }
  HttpStats stats() {
    return thread->on_loop([this] { return server->stats(); });
  }

  EventLoop loop;
  std::unique_ptr<HttpServer> server;
  std::uint16_t port = 0;
  std::optional<test::LoopThread> thread;
};

TEST_F(HttpStreamTest, WhoMayNotReadGetsNoStreamButTheReason) {
  begin();
  Client client = Client::tcp(port);
  client.send("GET /api/v1/stream?refused HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const test::Answer answer = read_answer(client);
  EXPECT_EQ(answer.status, 401);
  EXPECT_NE(answer.head.find("WWW-Authenticate: Bearer\r\n"), std::string::npos) << answer.head;
  EXPECT_EQ(stats().streams, 0u);
  client.send("GET /x HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(read_answer(client).status, 200) << "the connection goes on";
}

TEST_F(HttpStreamTest, BeginsWithWhatIsKnownAndGoesOnWithWhatComes) {
  begin();
  Client client = stream();
  EXPECT_NE(client.until("\r\n\r\n").find("text/event-stream"), std::string::npos);
  EXPECT_EQ(client.until("\n\n"), "retry: 1000\n\n");
  EXPECT_EQ(client.until("\n\n"), "event: dwell\ndata: \"first\"\n\n");
  for (int i = 0; i < 50; ++i) {
    broadcast(std::to_string(i));
    ASSERT_EQ(client.until("\n\n"), "event: dwell\ndata: " + std::to_string(i) + "\n\n");
  }
}

TEST_F(HttpStreamTest, ASlowReaderLosesEventsAndHoldsNobodyUp) {
  begin();
  Client slow = stream(1024);
  Client quick = stream();
  ASSERT_NE(slow.until("\"first\"\n\n"), "");
  ASSERT_NE(quick.until("\"first\"\n\n"), "");
  const std::string padding(64 * 1024, 'x');
  constexpr int kEvents = 400;  // 25 MB: more than any socket buffer holds
  for (int i = 0; i < kEvents; ++i) {
    broadcast(std::to_string(i) + padding);
    const std::string seen = quick.until("\n\n");
    ASSERT_EQ(seen.substr(0, 19 + std::to_string(i).size()), "event: dwell\ndata: " + std::to_string(i));
  }
  EXPECT_GT(stats().events_dropped, 0u);
  // The slow one still gets whole events, in order, the last one among them.
  int last = -1;
  while (last < kEvents - 1) {
    const std::string event = slow.until("\n\n");
    ASSERT_EQ(event.substr(0, 19), "event: dwell\ndata: ") << "after " << last;
    const int index = std::atoi(event.c_str() + 19);
    ASSERT_GT(index, last);
    last = index;
  }
}

TEST_F(HttpStreamTest, WhatMustBeAskedForComesToThoseAloneThatAsked) {
  begin();
  const auto wanted = [this] { return thread->on_loop([this] { return server->asked_for("traces"); }); };
  Client plain = stream();
  Client other = asking("trace&tracess");
  for (Client* client : {&plain, &other}) ASSERT_NE(client->until("\"first\"\n\n"), "");
  EXPECT_FALSE(wanted());
  Client asker = asking("more&traces");
  ASSERT_NE(asker.until("\"first\"\n\n"), "");
  EXPECT_TRUE(wanted());
  thread->on_loop([&] { server->broadcast_to_askers("traces", "1"); });
  broadcast("2");
  EXPECT_EQ(asker.until("\n\n"), "event: traces\ndata: 1\n\n");
  for (Client* client : {&asker, &plain, &other}) EXPECT_EQ(client->until("\n\n"), "event: dwell\ndata: 2\n\n");
}

// Traces for minutes, of which a slow reader takes little: what becomes of the dwell.
TEST_F(HttpStreamTest, TracesYieldToTheDwellWhereTheReaderIsSlow) {
  begin();
  Client slow = Client::tcp(port, 1024);
  slow.send("GET /api/v1/stream?traces HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_NE(slow.until("\"first\"\n\n"), "");
  const std::string traces(8 * 1024, 'x');
  constexpr int kDwells = 8;
  for (int i = 0; i < 50 * kDwells; ++i) {
    thread->on_loop([&] { server->broadcast_to_askers("traces", traces); });
    if (i % 50 == 25) broadcast(std::to_string(i));
  }
  EXPECT_GT(stats().events_dropped, 0u);
  int dwells = 0, before_the_first = 0;
  while (dwells < kDwells) {
    const std::string event = slow.until("\n\n");
    ASSERT_NE(event, "") << "after " << dwells << " of the dwell's";
    if (event.substr(0, 13) == "event: traces") {
      before_the_first += dwells == 0 ? 1 : 0;
    } else {
      EXPECT_EQ(event, "event: dwell\ndata: " + std::to_string(50 * dwells + 25) + "\n\n");
      ++dwells;
    }
  }
  EXPECT_LT(before_the_first, 100) << "what the kernel's buffers hold, of 400";
}

TEST_F(HttpStreamTest, AReaderThatTakesNothingAtAllIsGivenUp) {
  HttpOptions options;
  options.stream_write_time = std::chrono::milliseconds(200);
  begin(options);
  Client stuck = stream(1024);
  ASSERT_NE(stuck.until("\"first\"\n\n"), "");
  const std::string padding(1024 * 1024, 'x');
  bool gone = false;
  for (int tries = 0; tries < 2000 && !gone; ++tries) {
    broadcast(padding);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    gone = stats().streams == 0;
  }
  EXPECT_TRUE(gone);
}

TEST_F(HttpStreamTest, OneThatLeavesIsForgotten) {
  begin();
  {
    Client client = stream();
    ASSERT_NE(client.until("\"first\"\n\n"), "");
    EXPECT_EQ(stats().streams, 1u);
  }
  bool gone = false;
  for (int tries = 0; tries < 2000 && !gone; ++tries) {
    gone = stats().clients == 0;
    if (!gone) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_TRUE(gone);
  EXPECT_EQ(stats().streams, 0u);
}

TEST_F(HttpStreamTest, StreamsLeaveRoomForRequests) {
  HttpOptions options;
  options.clients = 128;
  options.streams = 96;
  begin(options);
  std::vector<Client> clients;
  for (std::size_t i = 0; i < options.streams; ++i) {
    clients.push_back(stream());
    ASSERT_NE(clients.back().until("\"first\"\n\n"), "");
  }
  Client refused = stream();
  EXPECT_EQ(read_answer(refused).status, 503);
  EXPECT_EQ(test::get(port, "/x").status, 200);
  broadcast("to all");
  for (Client& client : clients) ASSERT_EQ(client.until("\n\n"), "event: dwell\ndata: to all\n\n");
}

TEST_F(HttpStreamTest, HeadOfTheStreamEnds) {
  begin();
  Client client = Client::tcp(port);
  client.send("HEAD /api/v1/stream HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_NE(client.all().find("text/event-stream"), std::string::npos);
}

TEST_F(HttpStreamTest, HeadOfTheStreamNeedsTheRightsThatTheStreamNeeds) {
  begin();
  Client client = Client::tcp(port);
  client.send("HEAD /api/v1/stream?refused HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(read_answer(client, true).status, 401);
}

}  // namespace
}  // namespace dwell
