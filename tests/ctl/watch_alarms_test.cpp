// Alarms and limits: in the list of dwellctl, and on the screen of watch, where nothing is lost at 80 × 24.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "daemon/ctl/alarm_table.hpp"
#include "daemon/ctl/watch_page.hpp"
#include "daemon/report/number_text.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::ctl {
namespace {

using Json = nlohmann::ordered_json;

Json alarm(const char* name, const char* state, int count = 1) {
  return {{"name", name},      {"text", std::string(name) + " is wrong"},
          {"state", state},    {"since", "2026-11-23T07:00:00.000000Z"},
          {"count", count},    {"acknowledged_by", nullptr},
          {"comment", nullptr}};
}

AlarmsList listed() {
  Json seen = alarm("recording", "acknowledged");
  seen["acknowledged_by"] = "anna (uid 1000)";
  const Json value{
      {"unacknowledged", 2},
      {"left_out", 0},
      {"alarms", {alarm("channel:y1", "unacknowledged", 7), alarm("clock", "returned-unacknowledged"), seen}}};
  return alarms_from_json(value).value_or(AlarmsList{});
}

WatchState limited_dwell() {
  WatchState state;
  state.name = "bench 2";
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{20e3, 23e3}, Bounds{40.0, 70.0}}};
  state.take(make_view(test::sample_dwell(), rig, test::sample_run()), 100.0);
  return state;
}

std::vector<Page> alarm_pages(const WatchState& state, Size size) {
  std::vector<Page> pages;
  Controls controls;
  do {
    pages.push_back(draw(state, controls, nullptr, size, 100.1, "14:03:22"));
  } while (++controls.page < pages.back().pages);
  return pages;
}

// A line of what is given that holds the text; nothing, where none does.
std::optional<TextLine> line_with(const Page& page, const std::string& text) {
  for (const TextLine& line : page.lines)
    if (line.text.find(text) != std::string::npos) return line;
  return std::nullopt;
}

std::optional<TextLine> line_with(const std::vector<Page>& pages, const std::string& text) {
  for (const Page& page : pages)
    if (auto line = line_with(page, text)) return line;
  return std::nullopt;
}

TEST(AlarmsTable, HasALineForEachInTheOrderOfTheService) {
  EXPECT_EQ(alarms_table(listed()),
            "alarm       state                    since (UTC)          count  acknowledged by\n"
            "channel:y1  unacknowledged           2026-11-23 07:00:00      7  —                channel:y1 is wrong\n"
            "clock       returned-unacknowledged  2026-11-23 07:00:00      1  —                clock is wrong\n"
            "recording   acknowledged             2026-11-23 07:00:00      1  anna (uid 1000)  recording is wrong\n");
  EXPECT_EQ(alarms_table({}), "no alarms\n");
}

TEST(AlarmsTable, SaysWhatFoundNoRoom) {
  AlarmsList list = listed();
  list.left_out = 12;
  EXPECT_NE(alarms_table(list).find("12 more found no room in the list\n"), std::string::npos);
}

TEST(AlarmsTable, AnythingButAListIsNone) {
  for (const char* text : {"[]", "{}", R"({"alarms":3})", "null"})
    EXPECT_FALSE(alarms_from_json(Json::parse(text))) << text;
  EXPECT_EQ(alarms_from_json(Json::parse(R"({"alarms":[3,{"name":4}]})"))->alarms.size(), 2u);
}

TEST(WatchAlarms, ThoseThatNobodyKnowsOfAreCountedOnTopWithThePageOfTheList) {
  WatchState state = limited_dwell();
  EXPECT_FALSE(line_with(alarm_pages(state, {24, 80}), "not acknowledged"));
  state.take(listed(), 100.0);
  const std::vector<Page> pages = alarm_pages(state, {24, 80});
  for (const Page& page : pages) {
    const auto line = line_with(page, "1 alarm not acknowledged, page ");
    ASSERT_TRUE(line);
    EXPECT_EQ(line->style, Style::alarm);
    const std::size_t at = std::stoul(line->text.substr(line->text.find("page ") + 5));
    EXPECT_NE(line->text.find(": ", line->text.find("page ")), std::string::npos)
        << "the first of them: " << line->text;
    EXPECT_NE(line->text.find("; 1 more over"), std::string::npos) << line->text;
    EXPECT_TRUE(line_with(pages.at(at - 1), "unacknowledged: channel:y1, 7 times"));
  }
}

// After a device was back, watch said in red that it does not deliver.
TEST(WatchAlarms, OneThatIsOverIsNotToldAsOneThatLasts) {
  WatchState state = limited_dwell();
  const Json value{{"unacknowledged", 1}, {"left_out", 0}, {"alarms", {alarm("clock", "returned-unacknowledged")}}};
  state.take(alarms_from_json(value).value_or(AlarmsList{}), 100.0);
  const auto line = line_with(alarm_pages(state, {24, 80}), "1 alarm not acknowledged, over");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->style, Style::plain);
}

TEST(WatchAlarms, OnlyThoseThatLastAndWaitAreLoud) {
  WatchState state = limited_dwell();
  state.take(listed(), 100.0);
  const std::vector<Page> pages = alarm_pages(state, {24, 80});
  EXPECT_EQ(line_with(pages, "unacknowledged: channel:y1").value().style, Style::alarm);
  EXPECT_EQ(line_with(pages, "returned-unacknowledged: clock").value().style, Style::plain);
  EXPECT_EQ(line_with(pages, "acknowledged: recording").value().style, Style::plain);
  EXPECT_EQ(line_with(pages, "violated: stiffness of element 1").value().style, Style::alarm);
  EXPECT_EQ(line_with(pages, "kept: damping of element 1").value().style, Style::plain);
}

TEST(WatchAlarms, NothingIsLostAtAnySizeAndLimitsStandBeforeAlarms) {
  WatchState state = limited_dwell();
  state.take(listed(), 100.0);
  for (const Size size : {Size{24, 80}, Size{50, 160}, Size{16, 60}}) {
    std::string all;
    for (const Page& page : alarm_pages(state, size)) {
      EXPECT_LE(page.lines.size(), size.rows);
      for (const TextLine& line : page.lines) {
        EXPECT_LE(width(line.text), size.columns);
        all += line.text.substr(
                   line.text.find_first_not_of(' ') == std::string::npos ? 0 : line.text.find_first_not_of(' ')) +
               " ";
      }
    }
    std::size_t before = 0;
    for (const char* text : {"limits", "violated:", "kept:", "unacknowledged:", "channel:y1", "clock", "recording"}) {
      const std::size_t at = all.find(text, before);
      EXPECT_NE(at, std::string::npos) << text << " at " << size.columns << " columns:\n" << all;
      if (at != std::string::npos) before = at;
    }
  }
}

TEST(WatchAlarms, AListFromBeforeTheConnectionWasLostSaysSo) {
  WatchState state = limited_dwell();
  state.take(listed(), 100.0);
  state.trouble = "trying again";
  EXPECT_TRUE(line_with(alarm_pages(state, {24, 80}), "when last heard: 1 alarm not acknowledged"));
}

}  // namespace
}  // namespace dwell::ctl
