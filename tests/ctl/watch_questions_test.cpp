// What watch asks beside the stream, and what it makes of answers that come late or never.
#include "daemon/ctl/watch_questions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/ctl/watched.hpp"

namespace dwell::ctl {
namespace {

using Json = nlohmann::ordered_json;

// The service: answers by path; null: no answer.
struct Answers {
  std::map<std::string, Json> by_path{
      {"/api/v1/channels", {{"channels", Json::array()}}},
      {"/api/v1/alarms", {{"unacknowledged", 0}, {"alarms", Json::array()}}},
      {"/api/v1/health", Json::parse(R"({"rig":"bench","rig_sha256":"aa","utc":"2026-11-23T08:00:00.000000Z",
        "devices":[{"recorded":false,"ended":false}]})")},
      {"/api/v1/dwells?brief=1&count=100", {{"dwells", Json::array()}}},
      {"/api/v1/runs", {{"runs", Json::array()}}}};
  std::vector<std::string> asked;

  std::optional<Json> operator()(const std::string& path) {
    asked.push_back(path);
    const auto found = by_path.find(path);
    return found == by_path.end() || found->second.is_null() ? std::nullopt : std::optional(found->second);
  }
  [[nodiscard]] std::size_t times(const std::string& path) const {
    return static_cast<std::size_t>(std::count(asked.begin(), asked.end(), path));
  }
};

Json run(int number, const char* ended, bool tells = true) {
  const std::string path = "/api/v1/runs/bench-" + std::to_string(number) + ".dwell/dwells";
  return {{"run", number}, {"ended", ended}, {"dwells_at", tells ? Json(path) : Json()}};
}

// A dwell of the run that began at 07:30: from 07:45:00 to 07:50:00.
Json dwells_of_run(const char* rig_sha256) {
  return {{"rig_sha256", rig_sha256},
          {"dwells",
           {{{"index", 1},
             {"settled_s", 900.0},
             {"end_s", 1200.0},
             {"start_utc", "2026-11-23T07:30:00.000000Z"},
             {"elements", {{{"k", 1}, {"stiffness", {{"value", 20e3}}}, {"damping", {{"value", 50.0}}}}}}}}}};
}

std::string trend_of(const WatchState& state, double now_s) {
  const Section section = state.trend().section(*state.dwell(), now_s, 200);
  std::string text;
  for (const std::vector<TextLine>* lines : {&section.head, &section.body})
    for (const TextLine& line : *lines) text += line.text + "\n";
  return text;
}

struct WatchQuestions : testing::Test {
  Answers answers;
  double now_s = 110.0;
  Questions questions{std::ref(answers), [this] { return now_s; }};
  WatchState state;

  void SetUp() override {
    for (int i = 0; i <= 10; ++i) state.take(test::chain(1), 100.0 + i);
    questions.stream_began();
  }
  void turns(int count) {
    for (int i = 0; i < count; ++i) {
      now_s += 1.0;
      questions.turn(state);
    }
  }
};

TEST_F(WatchQuestions, AreAskedOncePerSecondAndOfASilentServiceSeldom) {
  now_s += 0.5;
  questions.turn(state);
  EXPECT_TRUE(answers.asked.empty()) << "the stream's first word comes first";
  turns(3);
  now_s += 0.5;
  questions.turn(state);
  now_s += 0.5;
  EXPECT_EQ(answers.times("/api/v1/health"), 3U);
  answers.by_path.clear();
  turns(15);
  EXPECT_EQ(answers.times("/api/v1/channels"), 3U + 2U) << "each unanswered question holds up the keys";
}

TEST_F(WatchQuestions, TheTrendHasTheDwellsOfTheHoursEarlierRuns) {
  const std::string path = "/api/v1/runs/bench-7.dwell/dwells?count=100";
  answers.by_path["/api/v1/runs"] = {
      {"runs",
       {run(5, "2026-11-23T06:50:00.000000Z"), run(6, "2026-11-23T07:40:00.000000Z", false),
        run(7, "2026-11-23T07:51:00.000000Z")}}};
  answers.by_path[path] = dwells_of_run("aa");
  turns(4);
  EXPECT_EQ(answers.times(path), 1U);
  EXPECT_EQ(answers.times("/api/v1/runs"), 1U);
  for (const std::string& asked : answers.asked) {
    EXPECT_EQ(asked.find("bench-5"), std::string::npos) << "it ended more than an hour ago";
    EXPECT_EQ(asked.find("bench-6"), std::string::npos) << "its dwells are not told";
  }
  EXPECT_EQ(trend_of(state, now_s).substr(0, 24), "trend of the last 902 s;") << trend_of(state, now_s);
}

TEST_F(WatchQuestions, RunsOfAnotherRigFileAreNoPartOfTheTrend) {
  const std::string path = "/api/v1/runs/bench-7.dwell/dwells?count=100";
  answers.by_path["/api/v1/runs"] = {{"runs", {run(7, "2026-11-23T07:51:00.000000Z")}}};
  answers.by_path[path] = dwells_of_run("bb");
  turns(4);
  EXPECT_EQ(answers.times(path), 1U);
  EXPECT_EQ(trend_of(state, now_s).substr(0, 22), "trend of the last 60 s") << trend_of(state, now_s);
}

TEST_F(WatchQuestions, ARunThatIsNotToldInTimeIsAskedForAgainAndThenNamedAsMissing) {
  answers.by_path["/api/v1/runs"] = {{"runs", {run(7, "2026-11-23T07:51:00.000000Z")}}};
  turns(3);
  EXPECT_EQ(trend_of(state, now_s).find("missing"), std::string::npos);
  turns(5);
  EXPECT_EQ(answers.times("/api/v1/runs/bench-7.dwell/dwells?count=100"), 3U);
  EXPECT_NE(trend_of(state, now_s).find("run 7 is missing"), std::string::npos) << trend_of(state, now_s);
}

TEST_F(WatchQuestions, ARecordingIsNotTakenForALiveRig) {
  turns(1);
  EXPECT_EQ(state.played(), Played::none);
  EXPECT_EQ(test::text_of(test::at(state, {}, {40, 120}, now_s)).find("recording"), std::string::npos);

  Json& devices = answers.by_path["/api/v1/health"]["devices"];
  devices = Json::parse(R"([{"recorded":true,"ended":true},{"recorded":true,"ended":false}])");
  turns(1);
  EXPECT_EQ(test::at(state, {}, {40, 120}, now_s).lines[2].text.rfind("recording, not live · ", 0), 0U);

  // Its channels have ended: by themselves they look like transducers that have gone.
  devices[1]["ended"] = true;
  turns(1);
  Dwell fault;
  fault.state = State::fault;
  fault.settling_reason = "the drive is not seen: y0 is end of data";
  state.take(make_view(fault, test::sample_rig(), test::sample_run()), now_s);
  const Page page = test::at(state, {}, {40, 120}, now_s + 10.0);
  EXPECT_EQ(page.lines[1].text, "recording ended");
  EXPECT_EQ(page.lines[1].style, Style::plain) << "that is so now";
  EXPECT_NE(test::text_of(page).find("NOT OF NOW: the recording has been played to its end"), std::string::npos);
  for (const TextLine& line : page.lines) EXPECT_NE(line.style, Style::alarm) << line.text;
}

}  // namespace
}  // namespace dwell::ctl
