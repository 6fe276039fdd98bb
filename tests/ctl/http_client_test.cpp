#include "daemon/ctl/http_client.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "daemon/ctl/control_client.hpp"
#include "tests/ctl/scripted_server.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell::ctl {
namespace {

using namespace std::chrono_literals;
using test::http_reply;
using test::Reply;
using test::ScriptedServer;

// What http_get makes of one answer: its body, or the reason after the address.
std::string outcome(const Reply& reply, const HttpLimits& limits = {}) {
  ScriptedServer server({reply});
  const auto url = parse_url(server.url());
  const auto answer = http_get(*url, "/api/v1/dwell", limits);
  if (answer) return std::to_string(answer->status) + " " + answer->body;
  EXPECT_EQ(answer.error().substr(0, server.url().size() + 2), server.url() + ": ");
  return answer.error().substr(server.url().size() + 2);
}

HttpLimits short_time() {
  HttpLimits limits;
  limits.time = 200ms;
  return limits;
}

TEST(HttpClient, AsksForThePathAndTakesTheBody) {
  ScriptedServer server({Reply{http_reply(200, "{}")}});
  const auto answer = http_get(*parse_url(server.url() + "/rig2/"), "/api/v1/dwell");
  ASSERT_TRUE(answer) << answer.error();
  EXPECT_EQ(answer->body, "{}");
  const std::string request = server.requests().at(0);
  EXPECT_EQ(request.substr(0, request.find("\r\n")), "GET /rig2/api/v1/dwell HTTP/1.1");
  EXPECT_NE(request.find("\r\nHost: 127.0.0.1:" + std::to_string(server.port()) + "\r\n"), std::string::npos);
}

TEST(HttpClient, SendsTheTokenWhereItIsGivenOne) {
  ScriptedServer server({Reply{http_reply(200, "{}")}, Reply{http_reply(200, "{}")}});
  Url url = *parse_url(server.url());
  ASSERT_TRUE(http_get(url, "/"));
  url.token = "0123456789abcdef0123456789abcdef";
  ASSERT_TRUE(http_get(url, "/"));
  EXPECT_EQ(server.requests().at(0).find("Authorization"), std::string::npos);
  EXPECT_NE(server.requests().at(1).find("\r\nAuthorization: Bearer 0123456789abcdef0123456789abcdef\r\n"),
            std::string::npos);
}

TEST(HttpClient, TakesAnAnswerWithoutALengthUntilItsEnd) {
  EXPECT_EQ(outcome({"HTTP/1.0 404 Not Found\r\n\r\nnothing"}), "404 nothing");
}

TEST(HttpClient, ATruncatedAnswerIsNoAnswer) {
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\n12345"}), "the answer ends after 5 of 10 bytes");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nContent-Le"}), "the connection was closed before an answer");
  EXPECT_EQ(outcome({""}), "the connection was closed before an answer");
}

TEST(HttpClient, AnOversizedAnswerIsRefusedBeforeItIsTaken) {
  HttpLimits limits;
  limits.body_bytes = 100;
  limits.header_bytes = 200;
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nContent-Length: 101\r\n\r\n", true}, limits),
            "the answer is too large, 101 bytes");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nContent-Length: 99999999999999999999999\r\n\r\n", true}, limits),
            "what answers is not an HTTP server");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\n\r\n" + std::string(150, 'x'), true}, limits), "the answer is too large");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nX: " + std::string(300, 'x'), true}, limits),
            "the answer's header is too long");
}

TEST(HttpClient, ASlowAnswerEndsWithTheTimeAllowed) {
  EXPECT_EQ(outcome({"", true}, short_time()), "no answer in time");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\n12345", true}, short_time()),
            "the answer did not end in time");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\n\r\n", false, true}, short_time()), "the answer did not end in time")
      << "a trickle of bytes must not keep the command";
}

TEST(HttpClient, WhatIsNotHttpIsSaidToBeSo) {
  EXPECT_EQ(outcome({"SSH-2.0-OpenSSH\r\n\r\n"}), "what answers is not an HTTP server");
  EXPECT_EQ(outcome({"HTTP/1.1 2x0 OK\r\n\r\n"}), "what answers is not an HTTP server");
  EXPECT_EQ(outcome({"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"}),
            "the answer's transfer encoding is not understood");
}

TEST(HttpClient, NobodyThereIsAReason) {
  std::string address;
  {
    const ScriptedServer server({});
    address = server.url();
  }
  const auto answer = http_get(*parse_url(address), "/");
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error(), address + ": Connection refused");
}

TEST(HttpClient, UnderstandsAddressesAndRefusesWhatIsNone) {
  const auto url = parse_url("http://[::1]:8380/a/");
  ASSERT_TRUE(url);
  EXPECT_EQ(url->host, "::1");
  EXPECT_EQ(url->port, "8380");
  EXPECT_EQ(url->prefix, "/a");
  EXPECT_EQ(parse_url("http://bench")->port, "80");
  for (const char* wrong : {"", "bench", "https://bench", "http://", "http://:80", "http://a:", "http://a:99999",
                            "http://[::1", "http://a b", "http://a/\r\nX: y"}) {
    EXPECT_FALSE(parse_url(wrong)) << wrong;
  }
}

RC_GTEST_PROP(HttpClient, SurvivesAnyBytes, ()) {
  const auto bytes = *rc::gen::container<std::string>(rc::gen::arbitrary<char>());
  const bool begins_well = *rc::gen::arbitrary<bool>();
  ScriptedServer server({Reply{(begins_well ? "HTTP/1.1 200 OK\r\n" : "") + bytes}});
  const auto answer = http_get(*parse_url(server.url()), "/");
  RC_ASSERT(answer.has_value() || !answer.error().empty());
}

using Next = EventStream::Next;

TEST(EventStream, DeliversEventsHoweverTheyAreCut) {
  ScriptedServer server(
      {Reply{test::stream_header() + ": comment\r\n\r\nevent: dwell\r\ndata: {\"a\":\r\ndata:1}\r\n\r\n" +
             "data: plain\n\nevent: cut\ndata: not ended"}});
  auto stream = EventStream::open(*parse_url(server.url()), "/api/v1/stream");
  ASSERT_TRUE(stream) << stream.error();
  EventStream::Event event;
  EXPECT_EQ(stream->next(event, in(5s)), Next::event);
  EXPECT_EQ(event.name, "dwell");
  EXPECT_EQ(event.data, "{\"a\":\n1}");
  EXPECT_EQ(stream->next(event, in(5s)), Next::event);
  EXPECT_EQ(event.name, "");
  EXPECT_EQ(event.data, "plain");
  EXPECT_EQ(stream->next(event, in(5s)), Next::ended) << "an event that was not ended is none";
}

TEST(EventStream, ASilentStreamIsATimeoutAndATrickleToo) {
  for (const bool trickle : {false, true}) {
    ScriptedServer server({Reply{test::stream_header(), true, trickle}});
    auto stream = EventStream::open(*parse_url(server.url()), "/api/v1/stream");
    ASSERT_TRUE(stream) << stream.error();
    EventStream::Event event;
    EXPECT_EQ(stream->next(event, in(100ms)), Next::timeout);
  }
}

TEST(EventStream, AnEndlessEventIsRefused) {
  HttpLimits limits;
  limits.event_bytes = 1000;
  ScriptedServer server({Reply{test::stream_header() + "data: " + std::string(2000, 'x'), true}});
  auto stream = EventStream::open(*parse_url(server.url()), "/api/v1/stream", limits);
  ASSERT_TRUE(stream) << stream.error();
  EventStream::Event event;
  const auto next = stream->next(event, in(5s));
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error(), "an event of the stream is too large");
}

TEST(ControlClient, ExchangesOneLineWithinItsBounds) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("control");
  ControlLimits limits;
  limits.time = 200ms;
  limits.line_bytes = 100;
  EXPECT_EQ(control_exchange(path, "{}", limits).error(), path + ": No such file or directory");
  EXPECT_EQ(control_exchange(std::string(200, 'x'), "{}", limits).error(),
            std::string(200, 'x') + ": the path is too long for a socket");
  ScriptedServer server(
      {Reply{"{\"done\":true}\nmore", true}, Reply{"{", false}, Reply{"{", true}, Reply{std::string(200, 'x'), true}},
      path);
  EXPECT_EQ(control_exchange(path, R"({"verb":"check"})", limits), R"({"done":true})");
  EXPECT_EQ(server.requests().at(0), R"({"verb":"check"})");
  EXPECT_EQ(control_exchange(path, "{}", limits).error(), path + ": the connection was closed before an answer");
  EXPECT_EQ(control_exchange(path, "{}", limits).error(), path + ": no answer in time");
  EXPECT_EQ(control_exchange(path, "{}", limits).error(), path + ": the answer is too long");
}

}  // namespace
}  // namespace dwell::ctl
