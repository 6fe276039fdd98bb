// What watch takes from the service's list of dwells, and how it asks for all of the last hour.
#include "daemon/ctl/earlier_dwells.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace dwell::ctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNow = "2026-11-23T08:00:00.000000Z";
constexpr double kHour_s = 3600.0;

// A dwell of the list, which ended so many seconds before kNow; it lasted 8 s.
Json ended(int index, double ago_s) {
  const double end_s = 7200.0 - ago_s;
  return {{"index", index},
          {"settled_s", end_s - 8.0},
          {"end_s", end_s},
          {"start_utc", "2026-11-23T06:00:00.000000Z"},
          {"elements",
           {{{"k", 1}, {"stiffness", {{"value", 24e3 + index}}}, {"damping", {{"value", 60.0}}}},
            {{"k", 2}, {"stiffness", nullptr}, {"damping", nullptr}}}}};
}

Json list_of(std::vector<Json> dwells) { return {{"dwells", std::move(dwells)}}; }

TEST(EarlierDwells, AreThoseOfTheSpanByTheClockOfTheService) {
  const auto dwells = earlier_dwells(list_of({ended(1, 3700.0), ended(2, 3500.0), ended(3, 10.0)}), kNow, kHour_s);
  ASSERT_EQ(dwells.size(), 2U);
  EXPECT_EQ(dwells[0].index, 2);
  EXPECT_NEAR(dwells[0].settled_ago_s, 3508.0, 1e-6);
  EXPECT_NEAR(dwells[1].ended_ago_s, 10.0, 1e-6);
  EXPECT_EQ(dwells[1].stiffness[0], 24003.0);
  EXPECT_EQ(dwells[1].damping[0], 60.0);
  EXPECT_TRUE(std::isnan(dwells[1].stiffness[1])) << "an element without coefficients has none";
}

TEST(EarlierDwells, WhatIsNoDwellThatSettledIsLeftOut) {
  Json unsettled = ended(1, 10.0), undated = ended(2, 10.0);
  unsettled["settled_s"] = nullptr;
  undated["start_utc"] = nullptr;
  EXPECT_TRUE(earlier_dwells(list_of({unsettled, undated, 7, nullptr}), kNow, kHour_s).empty());
  for (const char* text : {"[]", "{}", R"({"dwells":3})", "null"})
    EXPECT_TRUE(earlier_dwells(Json::parse(text), kNow, kHour_s).empty()) << text;
  EXPECT_TRUE(earlier_dwells(list_of({ended(1, 10.0)}), "", kHour_s).empty()) << "without a clock nothing is dated";
}

// A service with dwells 1 to 250, one each 10 s.
struct Service {
  std::vector<std::string> asked;
  std::optional<Json> operator()(const std::string& path) {
    asked.push_back(path);
    const auto at = path.find("from=");
    const int from = at == std::string::npos ? 151 : std::stoi(path.substr(at + 5));
    std::vector<Json> dwells;
    for (int i = from; i <= 250 && i < from + 100; ++i) dwells.push_back(ended(i, 10.0 * (251 - i)));
    return list_of(dwells);
  }
};

TEST(EarlierDwells, AreAskedForUntilTheSpanOrTheFirstDwellIsReached) {
  for (const double span_s : {kHour_s, 1505.0, 505.0}) {
    Service service;
    const auto dwells = ask_earlier_dwells(std::ref(service), kNow, span_s);
    ASSERT_TRUE(dwells);
    const std::size_t wanted = span_s == kHour_s ? 250 : span_s == 1505.0 ? 150 : 50;
    ASSERT_EQ(dwells->size(), wanted);
    for (std::size_t i = 1; i < wanted; ++i) EXPECT_EQ((*dwells)[i].index, (*dwells)[i - 1].index + 1);
    EXPECT_EQ((*dwells).back().index, 250);
    EXPECT_LE(service.asked.size(), 4U);
  }
}

TEST(EarlierDwells, AServerThatTellsOneAtATimeIsNotAskedForEver) {
  int asked = 0;
  const auto dwells = ask_earlier_dwells(
      [&asked](const std::string&) { return std::optional(list_of({ended(1'000'000 - asked++, 10.0)})); }, kNow,
      kHour_s);
  ASSERT_TRUE(dwells);
  EXPECT_EQ(asked, 10);
}

TEST(EarlierDwells, AServiceThatDoesNotAnswerHasNone) {
  EXPECT_FALSE(ask_earlier_dwells([](const std::string&) { return std::nullopt; }, kNow, kHour_s));
  int asked = 0;
  const auto dwells = ask_earlier_dwells(
      [&asked](const std::string&) -> std::optional<Json> {
        return asked++ == 0 ? std::optional(list_of({ended(200, 10.0)})) : std::nullopt;
      },
      kNow, kHour_s);
  ASSERT_TRUE(dwells);
  EXPECT_EQ(dwells->size(), 1U) << "what was told before it fell silent stays";
}

}  // namespace
}  // namespace dwell::ctl
