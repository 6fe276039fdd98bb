// A server that answers some paths, among them files and answers that are made later; and what an error looks like.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <semaphore>
#include <stdexcept>
#include <string>

#include "daemon/serve/http_request.hpp"
#include "daemon/serve/http_server.hpp"
#include "tests/daemon/sockets.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::test {

// A server that answers /hello, on a port of the kernel's choice.
struct HttpServerTest : testing::Test {
  void begin(HttpOptions options = {}) {
    options.port = 0;
    auto made = HttpServer::make(
        loop, options,
        [this](const HttpRequest& request) {
          const std::string_view path = request.path();
          if (request.method == HttpRequest::Method::post)
            return HttpReply{200, std::string(request.content_type) + "," + std::string(request.authorization) + "," +
                                      std::string(request.origin) + "," + std::string(request.cookie) + "," +
                                      std::string(request.from) + "," + std::string(request.body)};
          if (path == "/hello") return HttpReply{200, "{\"hello\":\"" + std::string(request.query()) + "\"}"};
          if (path == "/page") return HttpReply{200, "bytes", "text/html", "\"tag\"", "default-src 'self'"};
          if (path == "/large") return HttpReply{200, std::string(5'000'000, ' ')};
          if (path.substr(0, 6) == "/file/") {
            HttpReply reply{200, {}, "application/vnd.sqlite3"};
            reply.file_name = path.substr(6);
            reply.file = folder.path(reply.file_name);
            return reply;
          }
          if (path == "/later") return later([] { return HttpReply{200, "read"}; });
          if (path == "/hangs")
            return later([this] {
              hold.acquire();
              return HttpReply{200, "held"};
            });
          if (path == "/throws") return later([]() -> HttpReply { throw std::runtime_error("no"); });
          if (path == "/throw") throw std::runtime_error("no");
          return http_error(404, "nothing here");
        },
        [](const HttpRequest&) { return StreamBegin{}; });
    ASSERT_TRUE(made) << made.error().message;
    server = std::move(*made);
    port = server->port();
    thread.emplace(loop);
  }
  Answer ask(const std::string& request) {
    Client client = Client::tcp(port);
    client.send(request);
    return read_answer(client);
  }
  HttpStats stats() {
    return thread->on_loop([this] { return server->stats(); });
  }

  static HttpReply later(std::function<HttpReply()> make) {
    HttpReply reply;
    reply.later = std::move(make);
    return reply;
  }

  // A file of pseudo-random bytes.
  std::string made_file(const std::string& name, std::size_t bytes) {
    std::string text(bytes, '\0');
    std::uint32_t state = 1;
    for (char& c : text) c = static_cast<char>((state = state * 1664525U + 1013904223U) >> 24U);
    folder.write(name, text);
    return text;
  }
  std::string ask_for_file(const std::string& name, const char* method = "GET") {
    return std::string(method) + " /file/" + name + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }

  const record::Scratch folder;
  std::counting_semaphore<> hold{0};  // a disk that hangs until it is released
  EventLoop loop;
  std::unique_ptr<HttpServer> server;
  std::uint16_t port = 0;
  std::optional<LoopThread> thread;
};

inline void expect_error(const Answer& answer, int status) {
  EXPECT_EQ(answer.status, status) << answer.head;
  const auto json = nlohmann::json::parse(answer.body, nullptr, false);
  ASSERT_TRUE(json.is_object()) << answer.body;
  EXPECT_TRUE(json["error"].is_string());
  EXPECT_EQ(json["status"], status);
}

}  // namespace dwell::test
