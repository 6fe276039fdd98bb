// Memory that ends at any one point while a client is taken in and answered: that client may go without an answer, the
// next one must not.
#include <gtest/gtest.h>

#include "daemon/serve/http_request.hpp"
#include "daemon/serve/http_server.hpp"
#include "tests/daemon/failing_new.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

using test::Client;

TEST(HttpMemory, WhereverItEndsWhileOneClientIsWelcomedTheNextIsServed) {
  EventLoop loop;
  HttpOptions options;
  options.port = 0;
  const auto made = HttpServer::make(
      loop, options,
      [](const HttpRequest&) {
        return HttpReply{200, "{}"};
      },
      [](const HttpRequest&) { return StreamBegin{event_text("dwell", "{}")}; });
  ASSERT_TRUE(made);
  const std::uint16_t port = (*made)->port();
  loop.every(std::chrono::milliseconds(20), [&made] { (*made)->broadcast("dwell", "{}"); });
  test::LoopThread thread(loop);
  int answered_in_a_row = 0;
  for (int point = 0; point < 400 && answered_in_a_row < 10; ++point) {
    for (const char* path : {"/x", "/api/v1/stream"}) {
      thread.on_loop([point] { test::fail_allocation(point); });
      Client unlucky = Client::tcp(port);
      unlucky.send(std::string("GET ") + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
      answered_in_a_row = unlucky.until("\r\n\r\n").empty() ? 0 : answered_in_a_row + 1;
      thread.on_loop([] { test::fail_allocation(-1); });
      ASSERT_EQ(test::get(port, "/x").status, 200) << "after memory had ended at allocation " << point;
    }
  }
  EXPECT_EQ(answered_in_a_row, 10) << "the points tried reach beyond all that a client costs";
}

}  // namespace
}  // namespace dwell
