// Who may read and change over HTTP.
#include "daemon/serve/rights.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/api_schema.hpp"
#include "tests/daemon/log_to_read.hpp"

namespace dwell {
namespace {

constexpr const char* kRightToken = "0123456789abcdef0123456789abcdef";
constexpr std::int64_t kSecond_ns = 1'000'000'000;

HttpRequest from_afar(std::string_view authorization = {}) {
  HttpRequest request;
  request.from = "192.0.2.7";
  request.authorization = authorization;
  return request;
}

struct RightsTest : testing::Test {
  Rights rights(bool open, bool token = true) {
    return {{open, token ? std::optional<Token>(kRightToken) : std::nullopt}, log, [this] { return now_ns; }};
  }
  test::LogToRead log{"rights"};
  std::int64_t now_ns = kSecond_ns;
};

int outcome(const std::optional<HttpReply>& refused) { return refused ? refused->status : 200; }

TEST_F(RightsTest, ReadingNeedsTheTokenOnlyFromAnotherComputer) {
  Rights beyond = rights(false), open = rights(true);
  HttpRequest here = from_afar();
  here.from_loopback = true;
  EXPECT_EQ(outcome(beyond.reading_refused(from_afar())), 401);
  EXPECT_EQ(outcome(beyond.reading_refused(here)), 200);
  EXPECT_EQ(outcome(beyond.reading_refused(from_afar("Bearer 0123456789abcdef0123456789abcdef"))), 200);
  EXPECT_EQ(outcome(open.reading_refused(from_afar())), 200);
}

TEST_F(RightsTest, ChangingNeedsTheTokenEvenOnThisComputer) {
  Rights open = rights(true);
  HttpRequest here = from_afar();
  here.from_loopback = true;
  EXPECT_EQ(outcome(open.changing_refused(here)), 401);
  for (const char* wrong : {"Bearer", "Bearer ", "Bearer  0123456789abcdef0123456789abcdef", "Basic dTpw",
                            "0123456789abcdef0123456789abcdef", "Bearer 0123456789abcdef0123456789abcde"}) {
    here.authorization = wrong;
    EXPECT_EQ(outcome(open.changing_refused(here)), 401) << wrong;
  }
  for (const char* right : {"Bearer 0123456789abcdef0123456789abcdef", "bearer 0123456789abcdef0123456789abcdef"}) {
    here.authorization = right;
    EXPECT_EQ(outcome(open.changing_refused(here)), 200) << right;
  }
}

TEST_F(RightsTest, WithoutATokenFileNothingCanBeChangedWhateverIsShown) {
  Rights none = rights(true, false);
  EXPECT_EQ(outcome(none.changing_refused(from_afar())), 403);
  EXPECT_EQ(outcome(none.changing_refused(from_afar("Bearer "))), 403);
}

TEST_F(RightsTest, AnotherTokenEndsTheRightsOfTheOneBefore) {
  Rights its = rights(false);
  EXPECT_FALSE(its.renew({false, Token(kRightToken)})) << "the same";
  EXPECT_TRUE(its.renew({false, Token("another token of thirty-two bytes")}));
  EXPECT_EQ(outcome(its.changing_refused(from_afar("Bearer 0123456789abcdef0123456789abcdef"))), 401);
}

TEST_F(RightsTest, EveryWrongTokenIsCountedAndABurstOfThemIsOneLine) {
  Rights its = rights(false);
  for (int i = 0; i < 1000; ++i) (void)its.changing_refused(from_afar("Bearer wrong"));
  (void)its.changing_refused(from_afar());
  EXPECT_EQ(its.failures(), 1000u) << "to show none is no failure";
  now_ns += 10 * kSecond_ns;
  (void)its.reading_refused(from_afar("Bearer wrong"));
  EXPECT_EQ(log.lines(), (std::vector<std::string>{"warning a wrong token from 192.0.2.7",
                                                   "warning 1000 wrong tokens, the newest from 192.0.2.7"}));
}

// The cookie that a browser sends back: what stands before the first semicolon.
std::string sent_back(const HttpReply& reply) { return reply.cookie.substr(0, reply.cookie.find(';')); }

HttpRequest logging_in(std::string_view body) {
  HttpRequest request = from_afar();
  request.method = HttpRequest::Method::post;
  request.body = body;
  return request;
}

TEST_F(RightsTest, ABrowserThatShowedTheTokenOnceMayByItsCookie) {
  Rights its = rights(false);
  const HttpReply begun = its.login(logging_in(R"({"token":"0123456789abcdef0123456789abcdef"})"));
  EXPECT_EQ(begun.status, 200);
  EXPECT_NE(begun.cookie.find("; HttpOnly; SameSite=Strict"), std::string::npos) << begun.cookie;
  EXPECT_EQ(begun.cookie.find(kRightToken), std::string::npos) << "the token itself stays away from the browser";
  HttpRequest browser = from_afar();
  const std::string cookie = "other=1; " + sent_back(begun);
  browser.cookie = cookie;
  EXPECT_EQ(outcome(its.reading_refused(browser)), 200);
  EXPECT_EQ(outcome(its.changing_refused(browser)), 200);
  const HttpReply ended = its.logout(browser);
  EXPECT_NE(ended.cookie.find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(outcome(its.changing_refused(browser)), 401);
  EXPECT_EQ(its.failures(), 0u) << "a session that has ended is no wrong token";
}

TEST_F(RightsTest, NobodyLogsInWithAnythingElse) {
  Rights its = rights(true);
  for (const char* body : {"", "[]", "{}", R"({"token":3})", R"({"Token":"0123456789abcdef0123456789abcdef"})"})
    EXPECT_EQ(its.login(logging_in(body)).status, 400) << body;
  const HttpReply wrong = its.login(logging_in(R"({"token":"0123456789abcdef0123456789abcdeF"})"));
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(wrong.cookie, "");
  EXPECT_EQ(its.failures(), 1u);
  EXPECT_EQ(rights(true, false).login(logging_in(R"({"token":""})")).status, 403);
}

TEST_F(RightsTest, AnotherTokenEndsEverySession) {
  Rights its = rights(true);
  HttpRequest browser = from_afar();
  const std::string cookie = sent_back(its.login(logging_in(R"({"token":"0123456789abcdef0123456789abcdef"})")));
  browser.cookie = cookie;
  (void)its.renew({true, Token(kRightToken)});
  EXPECT_EQ(outcome(its.changing_refused(browser)), 200) << "the same token";
  (void)its.renew({true, Token("another token of thirty-two bytes")});
  EXPECT_EQ(outcome(its.changing_refused(browser)), 401);
}

TEST_F(RightsTest, AClientLearnsWhatItMayDo) {
  using nlohmann::json;
  Rights its = rights(false);
  EXPECT_EQ(json::parse(its.told(from_afar()).body), json({{"read", false}, {"change", false}, {"token", true}}));
  EXPECT_EQ(json::parse(its.told(from_afar("Bearer 0123456789abcdef0123456789abcdef")).body),
            json({{"read", true}, {"change", true}, {"token", true}}));
  EXPECT_EQ(json::parse(rights(true, false).told(from_afar()).body),
            json({{"read", true}, {"change", false}, {"token", false}}));
  EXPECT_EQ(test::ApiSchema().faults_of_text("rights", its.told(from_afar()).body), "");
}

}  // namespace
}  // namespace dwell
