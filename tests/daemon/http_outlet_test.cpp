// The live stream as an outlet: what is pushed, and when.
#include <gtest/gtest.h>

#include <optional>

#include "daemon/outlets/http.hpp"
#include "tests/daemon/log_to_read.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

struct HttpOutletTest : testing::Test {
  HttpOutletTest() {
    snapshot.dwell.state = State::settling;
    HttpOptions options;
    options.port = 0;
    auto made = Http::make(loop, options, {[this] { return view(); }});
    EXPECT_TRUE(made) << made.error().message;
    http = std::move(*made);
    thread.emplace(loop);
  }
  [[nodiscard]] ServiceView view() const {
    ServiceView now{rig, run, snapshot};
    now.now_ns = snapshot.t_ns;
    if (http) now.clients.http = http->server().stats();
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

// While the estimation hung, the stream was silent, as if the service were gone.
TEST_F(HttpOutletTest, TellsAgainOfADwellThatHasGoneStale) {
  show(1);
  test::Client client = test::Client::tcp(http->server().port());
  client.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  client.until("\"stale\":false");
  client.until("\n\n");
  const auto look = [this](double after_s) {
    thread->on_loop([&] {
      ServiceView now = view();
      now.now_ns += static_cast<std::int64_t>(after_s * 1e9);
      http->show(now);
      return 0;
    });
  };
  show(2);
  client.until("\n\n");
  look(2.4);  // one late estimate is no news
  look(3.0);
  EXPECT_NE(client.until("\n\n").find(R"("estimate_age_s":3.0,"stale":true)"), std::string::npos);
  look(4.0);
  EXPECT_NE(client.until("\n\n").find(R"("estimate_age_s":4.0)"), std::string::npos);
  thread.reset();
}

TEST_F(HttpOutletTest, ReadingAndChangingHaveTheirMethods) {
  const auto head_of = [this](const std::string& line) {
    test::Client client = test::Client::tcp(http->server().port());
    client.send(line + " HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    return test::read_answer(client, true).head;
  };
  for (const char* path : {"/api/v1/dwell", "/api/v1/stream", "/nowhere"}) {
    const std::string head = head_of(std::string("POST ") + path);
    EXPECT_NE(head.find(" 405 "), std::string::npos) << head;
    EXPECT_NE(head.find("Allow: GET, HEAD\r\n"), std::string::npos) << head;
  }
  const std::string head = head_of("GET /api/v1/start");
  EXPECT_NE(head.find(" 405 "), std::string::npos) << head;
  EXPECT_NE(head.find("Allow: POST\r\n"), std::string::npos) << head;
  thread.reset();
}

TEST_F(HttpOutletTest, TheStreamIsAskedForTracesAndForNothingElse) {
  const auto status_of = [this](const std::string& target) {
    test::Client client = test::Client::tcp(http->server().port());
    client.send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client.until("\r\n\r\n").substr(9, 3);
  };
  EXPECT_EQ(status_of("/api/v1/stream"), "200");
  EXPECT_EQ(status_of("/api/v1/stream?traces"), "200");
  for (const char* query : {"trace", "traces=1", "traces&traces", "from=3"})
    EXPECT_EQ(status_of(std::string("/api/v1/stream?") + query), "400") << query;
  EXPECT_EQ(status_of("/?kiosk"), status_of("/")) << "the page reads its own address";
  thread.reset();
}

TEST_F(HttpOutletTest, AnswersFromHowTheServiceStandsAtThatMoment) {
  test::Client client = test::Client::tcp(http->server().port());
  client.send("GET /api/v1/dwell HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_NE(client.until("\"settling\"").find("200 OK"), std::string::npos);
  thread.reset();
}

// On loopback with a token: everybody may read.
struct GuardedHttpTest : testing::Test {
  static constexpr const char* kGuard = "0123456789abcdef0123456789abcdef";

  GuardedHttpTest() : rights({true, Token(kGuard)}, log) {
    HttpOptions options;
    options.port = 0;
    HttpContent content{[this] { return ServiceView{rig, run, snapshot}; }};
    content.rights = &rights;
    content.operate = [this](const OperatorRequest& request,
                             const record::Person& by) -> tl::expected<void, std::string> {
      done.push_back(request.label + " by " + record::who(by));
      return {};
    };
    content.await_start = [this](std::function<void(const StartOutcome&)> tell) {
      loop.post([tell = std::move(tell), came = outcome] { tell(came); });
    };
    auto made = Http::make(loop, options, std::move(content));
    EXPECT_TRUE(made) << made.error().message;
    http = std::move(*made);
    thread.emplace(loop);
  }
  ~GuardedHttpTest() override { thread.reset(); }
  int post(const std::string& fields) {
    test::Client client = test::Client::tcp(http->server().port());
    client.send("POST /api/v1/start HTTP/1.1\r\nHost: localhost\r\n" + fields +
                "Content-Length: 16\r\n\r\n{\"label\":\"mine\"}");
    return test::read_answer(client).status;
  }

  test::LogToRead log{"guarded"};
  Rights rights;
  Rig rig;
  RunInfo run;
  Snapshot snapshot;
  std::vector<std::string> done;
  StartOutcome outcome{StartOutcome::Is::recorded, ""};  // of the next start
  EventLoop loop;
  std::unique_ptr<Http> http;
  std::optional<test::LoopThread> thread;
};

TEST_F(GuardedHttpTest, AStartIsAnsweredWithWhatCameOfIt) {
  test::Client client = test::Client::tcp(http->server().port());
  const auto order = [&](const std::string& verb, const std::string& body) {
    client.send("POST /api/v1/" + verb + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" +
                "Authorization: Bearer " + kGuard + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" +
                body);
    const test::Answer answer = test::read_answer(client);
    return std::to_string(answer.status) + " " + answer.body;
  };
  const std::string label = R"({"label":"mine"})";
  EXPECT_EQ(order("start", label), R"(200 {"done":true})");
  outcome = {StartOutcome::Is::not_recorded, "disk full"};
  EXPECT_EQ(order("start", label),
            R"(409 {"error":"the run was asked for and is not recorded: disk full","status":409})");
  outcome = {StartOutcome::Is::unknown, ""};
  EXPECT_EQ(order("start", label), R"(200 {"done":true,"recording":null})");
  EXPECT_EQ(order("stop", "{}"), R"(200 {"done":true})") << "of a stop nothing is awaited";
}

TEST_F(GuardedHttpTest, WhoShowsTheTokenMayAndIsRecordedByAddress) {
  const std::string json = "Content-Type: application/json\r\n";
  const std::string token = std::string("Authorization: Bearer ") + kGuard + "\r\n";
  EXPECT_EQ(post(json), 401);
  EXPECT_EQ(post(json + "Authorization: Bearer wrong\r\n"), 401);
  EXPECT_EQ(post(token), 415);
  EXPECT_EQ(post(json + token + "Origin: http://evil.example\r\n"), 403);
  EXPECT_TRUE(done.empty());
  EXPECT_EQ(post(json + token), 200);
  EXPECT_EQ(done, std::vector<std::string>{"mine by http:127.0.0.1 by token"});
}

TEST_F(GuardedHttpTest, AnOrderInTheQueryIsRefusedNotIgnored) {
  const auto status_of = [this](const std::string& line) {
    test::Client client = test::Client::tcp(http->server().port());
    client.send(line + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nAuthorization: Bearer " +
                kGuard + "\r\nContent-Length: 16\r\n\r\n{\"label\":\"mine\"}");
    return test::read_answer(client).status;
  };
  EXPECT_EQ(status_of("POST /api/v1/start?label=yours"), 400);
  EXPECT_TRUE(done.empty());
  EXPECT_EQ(status_of("POST /api/v1/start"), 200);
  EXPECT_EQ(status_of("GET /api/v1/rights?x"), 400);
  EXPECT_EQ(status_of("GET /api/v1/rights"), 200);
}

TEST_F(GuardedHttpTest, ABrowserLogsInAndActsByItsCookie) {
  test::Client client = test::Client::tcp(http->server().port());
  const auto log_in = [&](const std::string& fields) {
    client.send("POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" + fields +
                "Content-Length: 44\r\n\r\n{\"token\":\"" + kGuard + "\"}");
    return test::read_answer(client);
  };
  EXPECT_EQ(log_in("Origin: http://evil.example\r\n").status, 403);
  const test::Answer answer = log_in("Origin: http://localhost\r\n");
  EXPECT_EQ(answer.status, 200) << answer.head;
  const std::string mark = "Set-Cookie: ";
  const auto at = answer.head.find(mark);
  ASSERT_NE(at, std::string::npos) << answer.head;
  const std::string cookie = answer.head.substr(at + mark.size(), answer.head.find(';', at) - at - mark.size());
  const std::string fields = "Content-Type: application/json\r\nCookie: " + cookie + "\r\n";
  EXPECT_EQ(post(fields + "Origin: http://localhost:1\r\n"), 403) << "another port is another page";
  EXPECT_EQ(post(fields + "Origin: http://localhost\r\n"), 200);
  EXPECT_EQ(done.size(), 1u);
}

TEST_F(GuardedHttpTest, LoggingOutEndsTheStreamsOfItsSessionAndNoOther) {
  const auto post_to = [this](const std::string& verb, const std::string& fields, const std::string& body) {
    test::Client client = test::Client::tcp(http->server().port());
    client.send("POST /api/v1/" + verb + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" + fields +
                "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    return test::read_answer(client).head;
  };
  const auto log_in = [&] {
    const std::string head = post_to("login", "", std::string("{\"token\":\"") + kGuard + "\"}");
    const std::string mark = "Set-Cookie: ";
    const auto at = head.find(mark) + mark.size();
    return "Cookie: " + head.substr(at, head.find(';', at) - at) + "\r\n";
  };
  const auto stream = [this](const std::string& fields) {
    test::Client client = test::Client::tcp(http->server().port());
    client.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n" + fields + "\r\n");
    EXPECT_NE(client.until("\n\n").find(" 200 "), std::string::npos);
    return client;
  };
  const auto streams = [this] { return thread->on_loop([this] { return http->server().stats().streams; }); };
  const std::string one = log_in(), other = log_in(), foreign = "Cookie: dwell=" + std::string(64, '0') + "\r\n";
  test::Client of_one = stream(one), another_of_one = stream(one), of_other = stream(other),
               of_nobody = stream(foreign);
  post_to("logout", "", "{}");
  post_to("logout", foreign, "{}");
  EXPECT_EQ(streams(), 4u) << "no session has ended";
  post_to("logout", one, "{}");
  of_one.all();  // returns when the server closes
  another_of_one.all();
  EXPECT_EQ(streams(), 2u);
}

TEST_F(GuardedHttpTest, EveryStreamEndsWhereWhoMayReadIsAskedAnew) {
  test::Client stream = test::Client::tcp(http->server().port());
  stream.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_NE(stream.until("\n\n").find(" 200 "), std::string::npos);
  thread->on_loop([this] {
    http->end_streams();
    return 0;
  });
  stream.all();  // returns when the server closes
  EXPECT_EQ(thread->on_loop([this] { return http->server().stats().streams; }), 0u);
}

}  // namespace
}  // namespace dwell
