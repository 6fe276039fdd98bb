#include "daemon/record/result_text.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "daemon/record/run_entries.hpp"

namespace dwell::record {
namespace {

std::string entry(const std::string& dwell, const std::string& front = R"({"position":17,"final":true,"dwell":)") {
  return front + dwell + "}";
}

const std::string kDwell =
    R"({"index":3,"state":"measuring","u":1.5e-07,"big":-12.25E+30,"none":null,"list":[0,-0.0,[],{},"0 … 0.5 Hz\t\"x\"\/"],)"
    R"("nested":{"a":{"b":[true,false]}},"wide":"äß 漢字 🙂"})";

TEST(ResultText, WhatARecorderWritesIsReadWithoutParsing) {
  const std::string body = to_json(StoredResult{17, false, kDwell});
  const auto front = front_of(body);
  ASSERT_TRUE(front);
  EXPECT_EQ(front->position, 17u);
  EXPECT_FALSE(front->final);
  EXPECT_EQ(front->dwell, kDwell);
  EXPECT_TRUE(is_plain_object(front->dwell));
  EXPECT_TRUE(check_result(body));
}

TEST(ResultText, WhatIsWrittenOtherwiseIsParsed) {
  for (const std::string& body :
       {entry(kDwell, R"({ "position": 17, "final": true, "dwell": )"),
        entry(kDwell, R"({"final":true,"position":17,"dwell":)"), entry(R"({"x":1},"more":[1])"),
        entry("{\"x\":\"\\u0041\"}"), entry(R"({"x": 1})"), entry("{\"x\":1" + std::string(250, '0') + "}")}) {
    EXPECT_TRUE(check_result(body)) << body;
    const auto front = front_of(body);
    EXPECT_FALSE(front && is_plain_object(front->dwell)) << body;
  }
}

TEST(ResultText, WhatTheParserRefusesIsRefused) {
  for (const std::string& dwell : {std::string("{"),
                                   std::string("[]"),
                                   std::string("{}}"),
                                   std::string("{\"x\":01}"),
                                   std::string("{\"x\":1.}"),
                                   std::string("{\"x\":.5}"),
                                   std::string("{\"x\":+1}"),
                                   std::string("{\"x\":1e}"),
                                   std::string("{\"x\":1e999}"),
                                   std::string("{\"x\":nul}"),
                                   std::string("{\"x\" 1}"),
                                   std::string("{\"x\":1,}"),
                                   std::string("{\"x\":[1,]}"),
                                   std::string("{\"x\":\"\\q\"}"),
                                   std::string("{\"x\":\"\n\"}"),
                                   std::string("{\"x\":\"\xC0\xAF\"}"),
                                   std::string("{\"x\":\"\xED\xA0\x80\"}"),
                                   std::string("{\"x\":\"\xF5\x80\x80\x80\"}"),
                                   std::string("{\"x\":\"\xE2\x80\"}"),
                                   "{\"x\":" + std::string(80, '[') + std::string(80, ']') + "}",
                                   "{\"x\":\"" + std::string(kMaxJson, 'x') + "\"}"}) {
    EXPECT_FALSE(check_result(entry(dwell))) << dwell.substr(0, 100);
    EXPECT_FALSE(parse_result(entry(dwell))) << dwell.substr(0, 100);
  }
  EXPECT_FALSE(check_result(""));
  EXPECT_FALSE(check_result("{\"position\":"));
  EXPECT_FALSE(check_result(entry("{}", R"({"position":01,"final":true,"dwell":)")));
  EXPECT_FALSE(check_result(entry("{}", R"({"position":-1,"final":true,"dwell":)")));
}

// Property: the quick look never takes what the parser refuses, whatever is done to the text.
TEST(ResultText, TheQuickLookAgreesWithTheParserOnAlteredTexts) {
  const std::string body = entry(kDwell);
  std::mt19937 random(3);
  const std::string odd = "{}[]\",:\\0123456789.eE+-tfnul \x01\x7f\x80\xbf\xc3\xe2\xed\xf0\xf4\xff";
  int taken = 0, refused = 0;
  for (int i = 0; i < 50'000; ++i) {
    std::string text = body;
    for (std::size_t changes = 1 + random() % 3; changes > 0; --changes) {
      const std::size_t at = random() % text.size();
      const char c = odd[random() % odd.size()];
      switch (random() % 3) {
        case 0:
          text[at] = c;
          break;
        case 1:
          text.insert(at, 1, c);
          break;
        default:
          text.erase(at, 1 + random() % 4);
      }
    }
    const bool parses = parse_result(text).has_value();
    ASSERT_EQ(check_result(text).has_value(), parses) << text;
    ++(parses ? taken : refused);
  }
  EXPECT_GT(taken, 2000);
  EXPECT_GT(refused, 2000);
}

}  // namespace
}  // namespace dwell::record
