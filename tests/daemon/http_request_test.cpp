#include "daemon/serve/http_request.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

HttpRequest get_of(std::string_view target) {
  HttpRequest request;
  request.host = "127.0.0.1:8380";
  request.target = target;
  return request;
}

void expect_refused(const HttpRequest& request, int status, bool ends) {
  const auto refused = refusal(request, {"bench-pc"});
  ASSERT_TRUE(refused) << request.target;
  EXPECT_EQ(refused->reply.status, status);
  EXPECT_EQ(refused->ends, ends);
}

TEST(HttpRequest, IsAPathAndWhatFollowsItsQuestionMark) {
  const HttpRequest request = get_of("/api/v1/dwells?from=3&count=2?");
  EXPECT_EQ(request.path(), "/api/v1/dwells");
  EXPECT_EQ(request.query(), "from=3&count=2?");
  EXPECT_EQ(get_of("/metrics").query(), "");
  EXPECT_EQ(get_of("/metrics?").query(), "");
  EXPECT_FALSE(refusal(request, {}));
}

TEST(HttpRequest, IsToReadOrToPost) {
  using Method = HttpRequest::Method;
  HttpRequest request = get_of("/");
  request.method = Method::other;
  expect_refused(request, 405, true);
  EXPECT_EQ(refusal(request, {})->reply.allowed, "GET, HEAD");
  for (const char* changed : {"/api/v1/alarms/acknowledge", "/api/v1/start?label=x"}) {
    request.target = changed;
    EXPECT_EQ(refusal(request, {})->reply.allowed, "POST") << changed;
  }
  for (const Method method : {Method::get, Method::head, Method::post}) {
    request.method = method;
    EXPECT_FALSE(refusal(request, {}));
  }
}

TEST(HttpRequest, NamesOneHostWhichIsThisService) {
  HttpRequest request = get_of("/");
  request.host = "evil.example";
  expect_refused(request, 421, true);
  request.host = "bench-pc";
  EXPECT_FALSE(refusal(request, {"bench-pc"}));
  request.hosts = 2;
  expect_refused(request, 400, true);
  request.hosts = 0;
  request.host = {};
  expect_refused(request, 400, true);
  request.host_needed = false;
  EXPECT_FALSE(refusal(request, {})) << "HTTP/1.0";
}

TEST(HttpRequest, EndsWhereItsLengthOrItsChunksSay) {
  HttpRequest request = get_of("/");
  request.codings = 1;
  for (const char* unclear : {"", "xchunked", "identity", "chunked, identity", "chunked, chunked", "gzip, chunked"}) {
    request.coding = unclear;
    expect_refused(request, 400, true);
  }
  request.coding = "Chunked";
  EXPECT_FALSE(refusal(request, {}));
  request.has_length = true;
  expect_refused(request, 400, true);
  request.has_length = false;
  request.codings = 2;
  expect_refused(request, 400, true);
  request.codings = 1;
  request.host_needed = false;
  expect_refused(request, 400, true);
}

TEST(HttpRequest, ATargetThatIsNoPathIsRefusedAndTheConnectionGoesOn) {
  for (const char* target : {"", "?from=1", "*", "example.org:443"}) expect_refused(get_of(target), 400, false);
}

}  // namespace
}  // namespace dwell
