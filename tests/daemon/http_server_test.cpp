#include "daemon/serve/http_server.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <memory>
#include <thread>
#include <vector>

#include "tests/daemon/http_server_fixture.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

using test::Answer;
using test::Client;
using test::expect_error;
using test::HttpServerTest;
using test::read_answer;

TEST_F(HttpServerTest, AnswersOverAndOverOnOneConnection) {
  begin();
  Client client = Client::tcp(port);
  for (int i = 0; i < 5; ++i) {
    client.send("GET /hello?" + std::to_string(i) + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const Answer answer = read_answer(client);
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, "{\"hello\":\"" + std::to_string(i) + "\"}");
    EXPECT_NE(answer.head.find("application/json"), std::string::npos);
  }
}

TEST_F(HttpServerTest, AnswersRequestsSentAllAtOnceInTheirOrder) {
  begin();
  Client client = Client::tcp(port);
  client.send("GET /hello?1 HTTP/1.1\r\nHost: localhost\r\n\r\nGET /hello?2 HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(read_answer(client).body, "{\"hello\":\"1\"}");
  EXPECT_EQ(read_answer(client).body, "{\"hello\":\"2\"}");
}

TEST_F(HttpServerTest, HeadIsGetWithoutTheBody) {
  begin();
  Client client = Client::tcp(port);
  client.send("HEAD /hello HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  const Answer answer = read_answer(client, true);
  EXPECT_EQ(answer.status, 200);
  EXPECT_NE(answer.head.find("Content-Length: 12\r\n"), std::string::npos) << answer.head;
  EXPECT_EQ(client.all(), "");
}

TEST_F(HttpServerTest, APageCarriesItsPolicyAndIsSentOnce) {
  begin();
  Client client = Client::tcp(port);
  client.send("GET /page HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Answer first = read_answer(client);
  EXPECT_EQ(first.body, "bytes");
  for (const char* field : {"ETag: \"tag\"\r\n", "Content-Security-Policy: default-src 'self'\r\n",
                            "Cache-Control: no-cache\r\n", "X-Content-Type-Options: nosniff\r\n"})
    EXPECT_NE(first.head.find(field), std::string::npos) << field << first.head;
  client.send("GET /page HTTP/1.1\r\nHost: localhost\r\nIf-None-Match: \"tag\"\r\n\r\n");
  EXPECT_NE(client.until("\r\n\r\n").find("304 Not Modified"), std::string::npos);
  client.send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const Answer next = read_answer(client);
  EXPECT_EQ(next.body, "{\"hello\":\"\"}") << "304 has no body: the connection goes on";
  EXPECT_NE(next.head.find("Cache-Control: no-store\r\n"), std::string::npos);
}

TEST_F(HttpServerTest, WhatIsNotThereIs404WithAReason) {
  begin();
  expect_error(ask("GET /nowhere HTTP/1.1\r\nHost: localhost\r\n\r\n"), 404);
}

TEST_F(HttpServerTest, APostIsHandedOnWithItsBodyAndWhoSentIt) {
  begin();
  const Answer answer =
      ask("POST /hello HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nAuthorization: Bearer x\r\n"
          "Origin: http://localhost\r\nCookie: a=b\r\nContent-Length: 2\r\n\r\n{}");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, "application/json,Bearer x,http://localhost,a=b,127.0.0.1,{}");
  expect_error(ask("POST /hello HTTP/1.1\r\nHost: localhost\r\nContent-Length: 16385\r\n\r\n"), 413);
}

TEST_F(HttpServerTest, OtherMethodsAreRefused) {
  begin();
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "PATCH"}) {
    const Answer answer = ask(std::string(method) + " /hello HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
    expect_error(answer, 405);
    EXPECT_NE(answer.head.find("Allow: GET, HEAD\r\n"), std::string::npos) << answer.head;
  }
}

TEST_F(HttpServerTest, WhatIsNoRequestIs400) {
  begin();
  for (const char* junk : {"\x16\x03\x01\x02\r\n\r\n", "GET\r\n\r\n", "GET / HTTP/9.9\r\n\r\n",
                           "GET /hello HTTP/1.1\r\nbroken header\r\n\r\n",
                           "GET /hello HTTP/1.1\r\nContent-Length: minus one\r\n\r\n", "GET hello HTTP/1.1\r\n\r\n"})
    expect_error(ask(junk), 400);
}

TEST_F(HttpServerTest, HeaderAndBodyAreBounded) {
  begin();
  expect_error(ask("GET /hello HTTP/1.1\r\nX: " + std::string(20'000, 'a') + "\r\n\r\n"), 431);
  expect_error(ask("GET /hello HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n"), 413);
}

TEST_F(HttpServerTest, AnAnswerThatCannotBeMadeIs500AndTheServerGoesOn) {
  begin();
  expect_error(ask("GET /throw HTTP/1.1\r\nHost: localhost\r\n\r\n"), 500);
  EXPECT_EQ(ask("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 200);
}

TEST_F(HttpServerTest, AClientThatSendsByteByByteIsNotWaitedForLongerThanAnother) {
  HttpOptions options;
  options.request_time = std::chrono::milliseconds(300);
  begin(options);
  Client client = Client::tcp(port);
  // More than the deadline's worth of bytes, each well within it.
  bool cut_off = false;
  const std::string request = "GET /hello HTTP/1.1\r\nX: " + std::string(400, 'a');
  for (const char c : request) {
    if (!client.send(std::string_view(&c, 1))) {
      cut_off = true;
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_TRUE(cut_off);
}

TEST_F(HttpServerTest, AClientThatSaysNothingIsLetGo) {
  HttpOptions options;
  options.request_time = std::chrono::milliseconds(100);
  begin(options);
  Client client = Client::tcp(port);
  EXPECT_EQ(client.all(), "");  // returns when the server closes
}

TEST_F(HttpServerTest, TooManyClientsAreToldAndTheOthersServed) {
  HttpOptions options;
  options.clients = 8;
  options.kept_time = options.request_time;
  begin(options);
  std::vector<Client> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(Client::tcp(port));
    clients.back().send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_EQ(read_answer(clients.back()).status, 200);
  }
  Client late = Client::tcp(port);
  expect_error(read_answer(late), 503);
  clients.front().send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(read_answer(clients.front()).status, 200);
  EXPECT_EQ(stats().refused, 1u);
  clients.clear();
  int status = 503;
  for (int tries = 0; tries < 1000 && status == 503; ++tries) status = test::get(port, "/hello").status;
  EXPECT_EQ(status, 200) << "there is room again";
}

TEST_F(HttpServerTest, ConnectionsThatNeverAskedMakeRoomForOneThatDoes) {
  HttpOptions options;
  options.clients = 8;
  begin(options);
  Client served = Client::tcp(port);
  served.send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_EQ(read_answer(served).status, 200);
  std::vector<Client> idle;
  for (int i = 0; i < 100; ++i) {
    idle.push_back(Client::tcp(port));
    idle.back().send("GET /hel");  // begun, never ended
  }
  EXPECT_EQ(test::get(port, "/hello").status, 200) << "a newcomer is served";
  served.send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(read_answer(served).status, 200) << "and whoever was served before is not shut out";
  EXPECT_EQ(idle.front().all(), "") << "the oldest was closed";
  EXPECT_LE(stats().clients, 8u);
  EXPECT_GE(stats().displaced, 90u);
}

TEST_F(HttpServerTest, WhoIsConnectedStaysServedWhile5000OthersConnectAndSayNothing) {
  begin();
  Client polling = Client::tcp(port), stream = Client::tcp(port);
  const auto ask_again = [&polling] {
    polling.send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return read_answer(polling).status;
  };
  ASSERT_EQ(ask_again(), 200);
  stream.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_NE(stream.until("retry: 1000\n\n").find(" 200 "), std::string::npos);
  std::deque<Client> others;  // at most so many at once that this process has descriptors for them
  for (int i = 0; i < 5000; ++i) {
    others.push_back(Client::tcp(port));
    if (i % 3 > 0) others.back().send(i % 3 == 1 ? "GET /hel" : std::string(20'000, 'x'));
    if (others.size() > 300) others.pop_front();
    if (i % 100 != 0) continue;
    ASSERT_EQ(ask_again(), 200) << "after " << i;
    thread->on_loop([this] {
      server->broadcast("dwell", "{}");
      return 0;
    });
    ASSERT_EQ(stream.until("\n\n"), "event: dwell\ndata: {}\n\n");
    ASSERT_LE(stats().clients, HttpOptions().clients);
    ASSERT_EQ(test::get(port, "/hello").status, 200) << "and whoever comes now is served";
  }
  EXPECT_EQ(stats().events_dropped, 0u);
}

TEST_F(HttpServerTest, ConnectionsThatAskedOnceAndStayMakeRoomInTheEnd) {
  HttpOptions options;
  options.clients = 8;
  options.kept_time = std::chrono::milliseconds(0);
  begin(options);
  std::vector<Client> lingering;
  for (int i = 0; i < 8; ++i) {
    lingering.push_back(Client::tcp(port));
    lingering.back().send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_EQ(read_answer(lingering.back()).status, 200);
  }
  EXPECT_EQ(test::get(port, "/hello").status, 200);
  EXPECT_EQ(lingering.front().all(), "") << "the one that has been quiet longest was closed";
}

TEST_F(HttpServerTest, OnlyNamesOfThisServiceAreAnsweredSoThatAForeignPageCannotReadIt) {
  HttpOptions options;
  options.names = {"bench.example"};
  begin(options);
  const auto status = [this](const std::string& host) {
    return ask("GET /hello HTTP/1.1\r\n" + host + "Connection: close\r\n\r\n").status;
  };
  for (const char* ours : {"localhost", "LOCALHOST:8380", "127.0.0.1", "127.0.0.1:8380", "[::1]:8380", "192.0.2.1:80",
                           "bench.example", "Bench.Example:8380", "bench.example."})
    EXPECT_EQ(status(std::string("Host: ") + ours + "\r\n"), 200) << ours;
  for (const char* foreign :
       {"evil.example", "bench.example.evil.example", "localhost.evil.example", "127.0.0.1.evil.example",
        "evil.example:8380", "", ":8380", "[::1", "x y", "1.2.3.4.5", "0x7f000001", "localhost:evil"})
    EXPECT_EQ(status(std::string("Host: ") + foreign + "\r\n"), 421) << foreign;
  EXPECT_EQ(status("Host: localhost\r\nHost: evil.example\r\n"), 400);
  EXPECT_EQ(status(""), 400) << "HTTP/1.1 demands the field";
  EXPECT_EQ(ask("GET /hello HTTP/1.0\r\n\r\n").status, 200) << "1.0 knows no Host, and no browser speaks it";
  const Answer refused = ask("GET /hello HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  expect_error(refused, 421);
  EXPECT_NE(refused.body.find("evil.example"), std::string::npos) << refused.body;
  EXPECT_EQ(ask("GET /api/v1/stream HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 421);
}

TEST_F(HttpServerTest, LargeAnswersThatNobodyTakesHoldNoMoreMemoryThanIsSetAside) {
  HttpOptions options;
  options.answers_bytes = 12'000'000;
  begin(options);
  std::vector<Client> lazy;  // ask for 5 MB each, and read nothing
  for (int i = 0; i < 2; ++i) {
    lazy.push_back(Client::tcp(port, 1024));
    lazy.back().send("GET /large HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_NE(lazy.back().until("\r\n\r\n").find(" 200 "), std::string::npos);
  }
  expect_error(test::get(port, "/large"), 503);
  EXPECT_EQ(test::get(port, "/hello").status, 200) << "what is small is answered all the same";
  EXPECT_EQ(lazy.front().exactly(5'000'000).size(), 5'000'000u);
  int status = 503;
  for (int tries = 0; tries < 1000 && status == 503; ++tries) status = test::get(port, "/large").status;
  EXPECT_EQ(status, 200) << "and what has been taken makes room";
}

TEST_F(HttpServerTest, ABodyThatAGetBringsAlongIsIgnored) {
  begin();
  Client client = Client::tcp(port);
  client.send(
      "GET /hello HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n12345GET /hello?2 HTTP/1.1\r\nHost: "
      "localhost\r\n\r\n");
  EXPECT_EQ(read_answer(client).status, 200);
  EXPECT_EQ(read_answer(client).body, "{\"hello\":\"2\"}");
}

TEST_F(HttpServerTest, ABodyWithoutACertainEndIsNotTakenForTheNextRequest) {
  begin();
  const std::string next = "GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (const char* fields :
       {"Transfer-Encoding: xchunked\r\n", "Transfer-Encoding: identity\r\n",
        "Transfer-Encoding: chunked, identity\r\n", "Transfer-Encoding: identity\r\nContent-Length: 0\r\n",
        "Content-Length: 0\r\nTransfer-Encoding: chunked\r\n", "Transfer-Encoding: chunked\r\nContent-Length: 0\r\n",
        "Transfer-Encoding: xchunked\r\nTransfer-Encoding: chunked\r\n"}) {
    Client client = Client::tcp(port);
    client.send("POST /hello HTTP/1.1\r\nHost: localhost\r\n" + std::string(fields) + "\r\n0\r\n\r\n" + next);
    SCOPED_TRACE(fields);
    expect_error(read_answer(client), 400);
    EXPECT_EQ(client.all(), "") << "one answer, and the connection ends";
  }
  Client client = Client::tcp(port);
  client.send("POST /hello HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n" +
              next);
  EXPECT_EQ(read_answer(client).status, 200);
  EXPECT_EQ(read_answer(client).body, "{\"hello\":\"\"}");
}

// A client has sent two requests at once. Between them another one ends the server, and with it what its handler uses.
TEST(HttpServer, ARequestThatLiesThereAsTheServerEndsIsNotHandedOn) {
  EventLoop loop;
  std::unique_ptr<HttpServer> server;
  int handed_on = 0;
  HttpOptions options;
  options.port = 0;
  auto made = HttpServer::make(
      loop, options,
      [&](const HttpRequest& request) {
        ++handed_on;
        if (request.path() == "/end") server.reset();
        return HttpReply{};
      },
      [](const HttpRequest&) { return StreamBegin{}; });
  ASSERT_TRUE(made) << made.error().message;
  server = std::move(*made);
  const Client two = Client::tcp(server->port()), end = Client::tcp(server->port());
  while (server->stats().clients < 2) loop.context().poll();
  const std::string request = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";
  two.send(request + request);
  end.send("GET /end HTTP/1.1\r\nHost: localhost\r\n\r\n");
  while (server) loop.context().poll();
  loop.context().poll();
  EXPECT_EQ(handed_on, 2);
}

TEST(HttpServer, AnAddressThatIsNoneIsToldApartFromOneThatIsTaken) {
  EventLoop loop;
  const auto handler = [](const HttpRequest&) { return HttpReply{}; };
  const auto silent = [](const HttpRequest&) { return StreamBegin{}; };
  HttpOptions options;
  options.host = "no.such.host";
  const auto bad = HttpServer::make(loop, options, handler, silent);
  ASSERT_FALSE(bad);
  EXPECT_TRUE(bad.error().bad_address);
  EXPECT_NE(bad.error().message.find("no.such.host"), std::string::npos);

  options.host = "127.0.0.1";
  options.port = 0;
  const auto first = HttpServer::make(loop, options, handler, silent);
  ASSERT_TRUE(first);
  options.port = (*first)->port();
  const auto second = HttpServer::make(loop, options, handler, silent);
  ASSERT_FALSE(second);
  EXPECT_FALSE(second.error().bad_address);
  EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
}

}  // namespace
}  // namespace dwell
