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
    now.recording.state = recording;
    now.recording.runs = runs;
    now.recording.audits = audits;
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
  std::shared_ptr<const record::RunVerdicts> audits;
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
  EXPECT_EQ(answer("count=100")["runs"].size(), kRunsPerAnswer);
  for (const char* wrong : {"from=x", "from=-1", "count=101", "count=201"})
    EXPECT_EQ(get("/api/v1/runs", wrong).status, 400) << wrong;
}

// Somebody has copied a run's file within the directory: all have the number of the first.
TEST_F(RecorderJsonTest, PortionsGoOnThroughCopiesOfOneRunToTheEnd) {
  auto list = std::make_shared<record::ListedRuns>();
  for (const auto& [number, file] :
       std::vector<std::pair<int, std::string>>{{1, "a"}, {2, "a"}, {2, "b & c"}, {2, "d"}, {2, "e"}, {3, "a"}}) {
    record::ListedRun run;
    run.run = number;
    run.file = file + "-" + std::to_string(number) + "-20261123T031217Z.dwell";
    list->push_back(run);
  }
  runs = list;
  for (const int count : {1, 2, 3, 5, 6}) {
    std::vector<std::string> seen;
    std::string from = "0";
    for (int portions = 0; !from.empty(); ++portions) {
      ASSERT_LT(portions, 7) << "of " << count;
      const Parsed portion = answer(("from=" + from + "&count=" + std::to_string(count)).c_str());
      for (const Parsed& run : portion["runs"]) seen.push_back(run["file"]);
      const Parsed& next = portion["next"];
      from = next.is_null() ? "" : next.is_string() ? next.get<std::string>() : next.dump();
    }
    ASSERT_EQ(seen.size(), list->size()) << "in portions of " << count;
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], (*list)[i].file);
  }
  EXPECT_EQ(answer("from=1&count=1")["next"], 2) << "a number where that leads on";
  EXPECT_EQ(answer("from=1&count=2")["next"], "2:b%20%26%20c-2-20261123T031217Z.dwell");
  EXPECT_EQ(answer("from=2:c&count=1")["runs"][0]["file"], "d-2-20261123T031217Z.dwell")
      << "the file may have been deleted";
  for (const char* wrong : {"from=:a", "from=2:a&from=3", "from=x:a"})
    EXPECT_EQ(get("/api/v1/runs", wrong).status, 400) << wrong;
}

TEST_F(RecorderJsonTest, ARunThatGoesOnIsListedAsItStandsNow) {
  recording.emplace();
  recording->recording = true;
  recording->run = runs->back();
  recording->run.state = "recording";
  recording->run.bytes = 12345;
  EXPECT_EQ(answer("count=1")["runs"][0]["bytes"], 12345);
}

TEST_F(RecorderJsonTest, TellsOfEachRunWhetherItsFileIsIntactAndWhereItIsToBeHad) {
  recording.emplace();
  recording->directory = "/var/lib/dwell";
  auto list = std::make_shared<record::ListedRuns>(*runs);
  (*list)[247].state = "cut off";
  (*list)[248].state = "unreadable";
  (*list)[249].state = "recording";
  runs = list;
  record::RunVerdicts verdicts;
  verdicts[(*list)[246].file] = {"", record::AuditState::intact, "", {}, "", true, "2026-11-23T03:12:17.000000Z"};
  verdicts[(*list)[247].file] = {"", record::AuditState::open, "", 12.5, "", true, "2026-11-23T03:12:18.000000Z"};
  verdicts[(*list)[248].file] = {"",    record::AuditState::tampered, "entry 4: another head", {}, "",
                                 false, "2026-11-23T03:12:19.000000Z"};
  verdicts[(*list)[245].file] = {"Permission denied", record::AuditState::tampered, "", {}, "", false, ""};
  audits = std::make_shared<const record::RunVerdicts>(verdicts);
  const Parsed newest = answer("count=6")["runs"];
  std::string states;
  for (const Parsed& run : newest) states += run["audit"]["state"].get<std::string>() + ";";
  EXPECT_EQ(states, "waiting;not audited;intact;open;tampered;not audited;");
  EXPECT_EQ(newest[1]["audit"]["reason"], "Permission denied");
  EXPECT_EQ(newest[2]["audit"]["trusted"], true);
  EXPECT_EQ(newest[2]["audit"]["utc"], "2026-11-23T03:12:17.000000Z");
  EXPECT_EQ(newest[3]["audit"]["until_s"], 12.5);
  EXPECT_EQ(newest[4]["audit"]["where"], "entry 4: another head");
  EXPECT_EQ(newest[5]["audit"]["reason"], "the run goes on");
  EXPECT_NE(answer("from=1&count=1")["runs"][0]["audit"]["reason"].get<std::string>().find("only the newest 100"),
            std::string::npos);
  verdicts[(*list)[246].file].removed = true;
  audits = std::make_shared<const record::RunVerdicts>(verdicts);
  const Parsed removed = answer("count=4")["runs"][0];
  EXPECT_EQ(removed["state"], "removed");
  EXPECT_EQ(removed["no_download"], "its file was removed");
  EXPECT_TRUE(removed["download"].is_null());
  EXPECT_EQ(newest[2]["download"], "/api/v1/runs/bench-247-20261123T031217Z.dwell");
  EXPECT_TRUE(newest[2]["no_download"].is_null());
  for (int i = 3; i < 6; ++i) {
    EXPECT_TRUE(newest[i]["download"].is_null());
    EXPECT_TRUE(newest[i]["no_download"].is_string());
  }
}

TEST_F(RecorderJsonTest, TellsOfEachRunWhereItsDwellsAreTold) {
  recording.emplace();
  auto list = std::make_shared<record::ListedRuns>(*runs);
  for (record::ListedRun& run : *list) run.dwells = 2;
  (*list)[245].dwells = 0;
  (*list)[246].state = "cut off";
  (*list)[247].linked = true;
  (*list)[248].file = "be nch-249.dwell";
  (*list)[249].state = "recording";
  runs = list;
  record::RunVerdicts verdicts;
  verdicts[(*list)[244].file].removed = true;
  audits = std::make_shared<const record::RunVerdicts>(verdicts);
  const Parsed newest = answer("count=6")["runs"];
  EXPECT_TRUE(newest[0]["dwells_at"].is_null()) << "removed";
  EXPECT_TRUE(newest[1]["dwells_at"].is_null()) << "none has ended in it";
  EXPECT_EQ(newest[2]["dwells_at"], "/api/v1/runs/bench-247-20261123T031217Z.dwell/dwells") << "cut off";
  EXPECT_TRUE(newest[3]["dwells_at"].is_null()) << "a link";
  EXPECT_EQ(newest[4]["dwells_at"], "/api/v1/runs/be%20nch-249.dwell/dwells");
  EXPECT_TRUE(newest[5]["dwells_at"].is_null()) << "it goes on";
}

// Recorder and estimation each read the clock.
TEST_F(RecorderJsonTest, TheDwellsToldAreThoseOfTheRunThatBeganAtTheSameTime) {
  recording.emplace();
  auto list = std::make_shared<record::ListedRuns>(*runs);
  (*list)[248].begun_utc = "2026-11-23T06:59:59.990000Z";
  (*list)[249].begun_utc = "2026-11-23T07:00:30.000000Z";
  runs = list;
  const auto file_of = [this](const char* start_utc) {
    info.start_utc = start_utc;
    return Parsed::parse(get("/api/v1/dwells").body)["file"];
  };
  EXPECT_EQ(file_of("2026-11-23T07:00:00.000000Z"), (*list)[248].file);
  EXPECT_TRUE(file_of("2026-11-23T07:00:10.000000Z").is_null());
  EXPECT_TRUE(file_of("").is_null());
  recording->recording = true;
  recording->run = (*list)[249];
  EXPECT_EQ(file_of("2026-11-23T07:00:30.100000Z"), (*list)[249].file);
}

TEST_F(RecorderJsonTest, GivesTheFileOfAClosedRunOfTheListAndOfNothingElse) {
  recording.emplace();
  recording->directory = "/var/lib/dwell";
  auto list = std::make_shared<record::ListedRuns>(*runs);
  (*list)[247].state = "cut off";
  (*list)[248].file = "be\"nch-249-20261123T031217Z.dwell";
  (*list)[9].linked = true;
  runs = list;
  recording->recording = true;
  recording->run = list->back();
  const HttpReply file = get("/api/v1/runs/bench-3-20261123T031217Z.dwell");
  EXPECT_EQ(file.status, 200);
  EXPECT_EQ(file.file, "/var/lib/dwell/bench-3-20261123T031217Z.dwell");
  EXPECT_EQ(file.file_name, "bench-3-20261123T031217Z.dwell");
  const auto refused = [&](const std::string& name) {
    const HttpReply reply = get(("/api/v1/runs/" + name).c_str());
    EXPECT_EQ(reply.file, "") << name;
    return std::to_string(reply.status) + " " + Parsed::parse(reply.body)["error"].get<std::string>();
  };
  for (const char* other :
       {"", "ledger.dwell-ledger", "../rig.toml", "..", "key", "bench-3-20261123T031217Z.dwell/",
        "bench-3-20261123T031217Z.dwell-wal", "%2e%2e/rig.toml", "bench-999-20261123T031217Z.dwell"})
    EXPECT_EQ(refused(other).substr(0, 34), "404 there is no run of this name: ") << other;
  EXPECT_EQ(refused("bench-250-20261123T031217Z.dwell").substr(0, 22), "409 the run goes on: i");
  EXPECT_EQ(refused("bench-248-20261123T031217Z.dwell").substr(0, 23), "409 the run was cut off");
  const std::string link = refused("bench-10-20261123T031217Z.dwell");
  EXPECT_EQ(link.substr(0, 22), "409 its file is a link");
  const Parsed listed = answer("from=10&count=1")["runs"][0];
  EXPECT_TRUE(listed["download"].is_null()) << "what is refused is not offered";
  EXPECT_EQ("409 " + listed["no_download"].get<std::string>(), link);
  EXPECT_EQ(refused("be\"nch-249-20261123T031217Z.dwell").substr(0, 25), "409 its name has unusual ");
}

TEST_F(RecorderJsonTest, HealthSaysWhatIsRecordedOrWhyNot) {
  EXPECT_TRUE(health().is_null()) << "this service does not record";
  recording.emplace();
  recording->why_not = "disk full";
  recording->alarms = {{"recording", "the run is not recorded: disk full"}};
  EXPECT_EQ(health()["reason"], "disk full");
  EXPECT_TRUE(health()["run"].is_null());
  EXPECT_NE(get("/api/v1/health").body.find("\"the run is not recorded: disk full"), std::string::npos);
  recording->recording = true;
  recording->run = runs->front();
  recording->committed_ns = 9'250'000'000;
  EXPECT_EQ(health()["run"]["run"], 1);
  EXPECT_NEAR(health()["since_commit_s"].get<double>(), 0.75, 1e-9);
  EXPECT_TRUE(health()["reason"].is_null());
}

}  // namespace
}  // namespace dwell
