// What can be changed over HTTP, and what a foreign page cannot.
#include "daemon/serve/http_actions.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/api_schema.hpp"

namespace dwell {
namespace {

HttpRequest post(std::string_view body) {
  HttpRequest request;
  request.method = HttpRequest::Method::post;
  request.host = "bench:8380";
  request.content_type = "application/json";
  request.body = body;
  return request;
}

int status(const std::optional<HttpReply>& refused) { return refused ? refused->status : 200; }

TEST(HttpActions, AreTheVerbsOfTheControlSocket) {
  for (const char* verb : {"start", "stop", "label", "rearm"}) {
    EXPECT_EQ(posted_verb(std::string("/api/v1/") + verb), verb);
    EXPECT_TRUE(is_operator_verb(verb));
  }
  EXPECT_EQ(posted_verb("/api/v1/alarms/acknowledge"), "acknowledge");
  EXPECT_TRUE(is_operator_verb("acknowledge"));
  for (const char* none : {"/api/v1/", "/api/v1/alarms", "/api/v1/acknowledge", "/api/v1/dwell", "/api/v1/start/",
                           "/start", "", "/api/v1/reload"})
    EXPECT_FALSE(posted_verb(none)) << none;
}

TEST(HttpActions, AskTheSameAsTheControlSocketDoes) {
  std::vector<OperatorRequest> asked;
  const Operate operate = [&](const OperatorRequest& request) -> tl::expected<void, std::string> {
    asked.push_back(request);
    if (asked.size() > 3) return tl::unexpected(std::string("nothing to stop: no run goes on"));
    return {};
  };
  EXPECT_EQ(action_answer("start", post(R"({"label":"sweep 3","comment":"new damper"})"), operate).body,
            R"({"done":true})");
  EXPECT_EQ(test::ApiSchema().faults_of_text("done", action_answer("rearm", post("{}"), operate).body), "");
  EXPECT_EQ(action_answer("rearm", post("{}"), operate).status, 200);
  const HttpReply late = action_answer("stop", post("{}"), operate);
  EXPECT_EQ(late.status, 409);
  EXPECT_NE(late.body.find("nothing to stop"), std::string::npos);
  ASSERT_EQ(asked.size(), 4u);
  EXPECT_EQ(asked[0].label, "sweep 3");
  EXPECT_EQ(asked[0].comment, "new damper");
  EXPECT_EQ(asked[1].verb, OperatorRequest::Verb::rearm);
}

// A misspelt comment was lost without a word, and the dwell ended.
TEST(HttpActions, AMemberThatTheVerbDoesNotKnowIsRefused) {
  int asked = 0;
  const Operate operate = [&](const OperatorRequest&) -> tl::expected<void, std::string> {
    ++asked;
    return {};
  };
  const auto why = [&](const char* verb, const char* body) {
    const HttpReply reply = action_answer(verb, post(body), operate);
    EXPECT_EQ(reply.status, 400) << reply.body;
    return Json::parse(reply.body)["error"].get<std::string>();
  };
  EXPECT_EQ(why("rearm", R"({"coment":"new damper"})"), "\"coment\" is not understood: rearm takes comment");
  EXPECT_EQ(why("stop", R"({"label":"sweep 3"})"), "\"label\" is not understood: stop takes comment");
  EXPECT_EQ(why("start", R"({"label":"sweep 3","x":1})"), "\"x\" is not understood: start takes label and comment");
  EXPECT_EQ(why("label", "{}"), "no label: expected \"label\": \"what is measured\"");
  EXPECT_EQ(asked, 0);
}

TEST(HttpActions, AMemberThatIsGivenTwiceIsRefused) {
  int asked = 0;
  const Operate operate = [&](const OperatorRequest&) -> tl::expected<void, std::string> {
    ++asked;
    return {};
  };
  const HttpReply reply = action_answer("start", post(R"({"label":"sweep 3","label":"sweep 4"})"), operate);
  EXPECT_EQ(reply.status, 400);
  EXPECT_NE(reply.body.find(R"(\"label\" is given twice, expected once)"), std::string::npos) << reply.body;
  EXPECT_EQ(asked, 0);
  EXPECT_TRUE(parse_request(R"({"label":"a","more":{"label":"b"},"list":[{"label":"c"},{"label":"d"}]})"))
      << "members of other objects";
}

TEST(HttpActions, AnAlarmIsAcknowledgedByItsName) {
  std::vector<OperatorRequest> asked;
  const Operate operate = [&](const OperatorRequest& request) -> tl::expected<void, std::string> {
    asked.push_back(request);
    return {};
  };
  EXPECT_EQ(action_answer("acknowledge", post(R"({"alarm":"channel:y1","comment":"cable pulled"})"), operate).status,
            200);
  EXPECT_EQ(action_answer("acknowledge", post("{}"), operate).status, 400);
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_EQ(asked[0].verb, OperatorRequest::Verb::acknowledge);
  EXPECT_EQ(asked[0].alarm, "channel:y1");
  EXPECT_EQ(asked[0].comment, "cable pulled");
}

TEST(HttpActions, ABodyThatIsNotUtf8IsRefusedWithItsPlace) {
  const Operate never = [](const OperatorRequest&) -> tl::expected<void, std::string> {
    ADD_FAILURE();
    return {};
  };
  const HttpReply reply = action_answer("start",
                                        post("{\"label\":\"gepr\xfc"
                                             "ft\"}"),
                                        never);
  EXPECT_EQ(reply.status, 400);
  EXPECT_NE(reply.body.find("byte 15 is 0xFC, expected text in UTF-8"), std::string::npos) << reply.body;
}

TEST(HttpActions, ABodyThatCannotBeUsedAsksForNothing) {
  const Operate never = [](const OperatorRequest&) -> tl::expected<void, std::string> {
    ADD_FAILURE();
    return {};
  };
  const std::string deep(1000, '['), label(201, 'x');
  for (const std::string& body :
       {std::string(), std::string("{"), std::string("[]"), std::string("{}"), deep, "{\"label\":\"" + label + "\"}",
        std::string(R"({"label":3})"), std::string(R"({"label":"a\nb"})"), std::string("{\"label\":\"a\u202Eb\"}"),
        std::string("{\"label\":\"\xff\"}")})
    EXPECT_EQ(action_answer("start", post(body), never).status, 400) << body;
}

TEST(HttpActions, ComeFromTheOwnPageOrFromNoPage) {
  HttpRequest request = post("{}");
  EXPECT_EQ(status(foreign_refusal(request)), 200) << "a program states no origin";
  for (const char* own : {"http://bench:8380", "https://bench:8380", "http://BENCH:8380"}) {
    request.origin = own;
    EXPECT_EQ(status(foreign_refusal(request)), 200) << own;
  }
  for (const char* foreign : {"http://bench", "http://bench:8381", "http://evil.example", "null", "bench:8380",
                              "http://bench:8380.evil.example", "http://evil.example/http://bench:8380", "://"}) {
    request.origin = foreign;
    EXPECT_EQ(status(foreign_refusal(request)), 403) << foreign;
  }
}

TEST(HttpActions, AreNothingThatAFormCouldSend) {
  HttpRequest request = post("{}");
  for (const char* json :
       {"application/json", "Application/JSON", "application/json; charset=utf-8", "application/json ;charset=utf-8"}) {
    request.content_type = json;
    EXPECT_EQ(status(foreign_refusal(request)), 200) << json;
  }
  for (const char* form : {"", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data",
                           "text/plain; application/json", "application/jsonx"}) {
    request.content_type = form;
    EXPECT_EQ(status(foreign_refusal(request)), 415) << form;
  }
}

}  // namespace
}  // namespace dwell
