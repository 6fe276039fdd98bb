// The lines of the log that are kept for /api/v1/events.
#include "daemon/log/newest_lines.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/serve/events_json.hpp"

namespace dwell {
namespace {

using Json = nlohmann::json;

struct EventsTest : testing::Test {
  Json events(std::string_view query = {}) {
    ServiceView now{rig, run, snapshot};
    now.events = &lines;
    const HttpReply reply = events_answer(now, query);
    EXPECT_EQ(reply.status, 200) << reply.body;
    return Json::parse(reply.body);
  }
  Rig rig;
  RunInfo run;
  Snapshot snapshot;
  NewestLines lines;
};

TEST_F(EventsTest, AreTheNewestLinesWithTheirInstant) {
  lines.push(Level::info, "state idle -> settling, dwell 1", 1'700'000'000'250'000'000);
  lines.push(Level::warning, "device amplifier: timeout", 1'700'000'001'000'000'000);
  const Json told = events();
  ASSERT_EQ(told["events"].size(), 2U);
  EXPECT_EQ(told["events"][0]["utc"], "2023-11-14T22:13:20.250000Z");
  EXPECT_EQ(told["events"][0]["level"], "info");
  EXPECT_EQ(told["events"][1]["number"], 2);
  EXPECT_EQ(told["next"], 3);
  EXPECT_EQ(events("from=2")["events"].size(), 1U);
  EXPECT_EQ(events("from=3")["events"].size(), 0U);
  EXPECT_EQ(events("from=3")["next"], 3) << "ask again from there";
  EXPECT_EQ(events("count=1")["events"][0]["number"], 2);
}

TEST_F(EventsTest, AChangeOfStateTellsTheStateThatBegan) {
  lines.push(Level::info, "state idle -> settling, dwell 1", 0, "settling");
  lines.push(Level::info, "run 3 ended", 0);
  EXPECT_EQ(events()["events"][0]["state"], "settling");
  EXPECT_TRUE(events()["events"][1]["state"].is_null());
}

TEST_F(EventsTest, AreBoundedInNumberAndLengthWhateverIsLogged) {
  for (int i = 0; i < 2000; ++i) lines.push(Level::info, std::string(10'000, 'x'), i);
  const Json told = events("from=1");
  EXPECT_EQ(told["events"].size(), kEventsPerAnswer);
  EXPECT_EQ(told["events"][0]["number"], 2000 - NewestLines::kLines + 1);
  EXPECT_EQ(told["next"], told["events"].back()["number"].get<int>() + 1);
  EXPECT_LE(lines.newest(1)[0].text.size(), NewestLines::kBytes + 3);
}

TEST_F(EventsTest, ALongLineIsNotCutWithinACharacter) {
  lines.push(Level::info, std::string(NewestLines::kBytes - 1, 'x') + "ü", 0);
  EXPECT_EQ(lines.newest(1)[0].text, std::string(NewestLines::kBytes - 1, 'x') + "…");
}

TEST_F(EventsTest, AQueryThatIsNotUnderstoodIsRefused) {
  ServiceView now{rig, run, snapshot};
  for (const char* query : {"level=error", "count=0", "from=x", "brief=1"})
    EXPECT_EQ(events_answer(now, query).status, 400) << query;
  EXPECT_EQ(Json::parse(events_answer(now, "").body)["events"].size(), 0U);
}

}  // namespace
}  // namespace dwell
