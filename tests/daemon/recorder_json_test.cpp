#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/serve/api.hpp"

namespace dwell {
namespace {

using Parsed = nlohmann::json;

struct RecorderJsonTest : testing::Test {
  RecorderJsonTest() {
    rig.name = "bench";
    auto list = std::make_shared<record::ListedRuns>();
    for (int number = 1; number <= 250; ++number) {
      record::ListedRun run;
      run.run = number;
      run.file = "bench-" + std::to_string(number) + "-20261123T031217Z.dwell";
      run.state = "closed";
      list->push_back(run);
    }
    runs = list;
  }
  [[nodiscard]] HttpReply get(const char* path, const char* query = "") const {
    ServiceView now{rig, info, snapshot};
    now.now_ns = 10'000'000'000;
    now.recorder = recording;
    now.runs = runs;
    now.health = judge_health(rig, snapshot, now.now_ns, now.gpio, now.log, "",
                              recording ? recording->alarms : std::vector<record::RecorderAlarm>());
    return http_answer(now, path, query);
  }
  [[nodiscard]] Parsed answer(const char* query) const { return Parsed::parse(get("/api/v1/runs", query).body); }
  [[nodiscard]] Parsed health() const { return Parsed::parse(get("/api/v1/health").body)["recorder"]; }

  Rig rig;
  RunInfo info;
  Snapshot snapshot;
  std::optional<record::RecorderState> recording;
  std::shared_ptr<const record::ListedRuns> runs;
};

TEST_F(RecorderJsonTest, RunsComeInBoundedPortionsTheNewestFirstAsked) {
  const Parsed newest = answer("");
  EXPECT_EQ(newest["total"], 250);
  ASSERT_EQ(newest["runs"].size(), kRunsPerAnswer);
  EXPECT_EQ(newest["runs"].front()["run"], 151);
  EXPECT_TRUE(newest["next"].is_null());
  const Parsed first = answer("from=1&count=2");
  ASSERT_EQ(first["runs"].size(), 2u);
  EXPECT_EQ(first["next"], 3);
  EXPECT_EQ(answer("from=251")["runs"].size(), 0u);
  EXPECT_EQ(answer("count=1000")["runs"].size(), kRunsPerAnswer);
  EXPECT_EQ(get("/api/v1/runs", "from=x").status, 400);
}

TEST_F(RecorderJsonTest, ARunThatGoesOnIsListedAsItStandsNow) {
  recording.emplace();
  recording->recording = true;
  recording->run = runs->back();
  recording->run.state = "recording";
  recording->run.bytes = 12345;
  EXPECT_EQ(answer("count=1")["runs"][0]["bytes"], 12345);
}

TEST_F(RecorderJsonTest, HealthSaysWhatIsRecordedOrWhyNot) {
  EXPECT_TRUE(health().is_null()) << "this service does not record";
  recording.emplace();
  recording->why_not = "disk full";
  recording->alarms = {{"recording", "the run is not recorded: disk full"}};
  EXPECT_EQ(health()["reason"], "disk full");
  EXPECT_TRUE(health()["run"].is_null());
  EXPECT_NE(get("/api/v1/health").body.find("recording: the run is not recorded: disk full"), std::string::npos);
  recording->recording = true;
  recording->run = runs->front();
  recording->committed_ns = 9'250'000'000;
  EXPECT_EQ(health()["run"]["run"], 1);
  EXPECT_NEAR(health()["since_commit_s"].get<double>(), 0.75, 1e-9);
  EXPECT_TRUE(health()["reason"].is_null());
}

}  // namespace
}  // namespace dwell
