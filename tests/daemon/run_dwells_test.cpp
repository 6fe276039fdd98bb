// The dwells of an earlier run, read from its file: what is told, what a damaged or hostile file leads to, and that a
// file is read once.
#include "daemon/serve/run_dwells.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "daemon/record/chain_file.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/run/stored_model.hpp"
#include "tests/api_schema.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/record/sample_run.hpp"
#include "tests/record/scratch.hpp"

namespace dwell {
namespace {

using Json = nlohmann::json;

struct RunDwellsTest : testing::Test {
  RunDwellsTest() {
    rig.limits = {{1, Bounds{0.0, 10.0}, std::nullopt}};
    run = record::sample_run_file(folder.path(kFile), key, "{}");
    std::ifstream text(DWELL_SOURCE "/config/rigs/clamped.toml");
    run.header.rig.text = {std::istreambuf_iterator<char>(text), {}};
    run.results.clear();
    for (int index = 1; index <= 3; ++index) {
      run.results.push_back({static_cast<std::uint64_t>(index), false, dwell_text(index, State::measuring)});
      run.results.push_back({static_cast<std::uint64_t>(index), true, dwell_text(index, State::complete)});
    }
    VerifiedDwell verified;
    verified.dwell.index = 2;
    verified.verification = test::sample_verification();
    for (const Verdict verdict : {Verdict::not_adequate, Verdict::adequate}) {  // the newest one counts
      verified.verification.verdict = verdict;
      run.models.push_back(stored_model(std::make_shared<const VerifiedDwell>(verified), rig));
      run.models.back().utc = "2026-07-01T10:12:10Z";
    }
    recorder.directory = folder.path("");
    list(kFile, "closed");
  }
  [[nodiscard]] std::string dwell_text(int index, State state) const {
    Dwell dwell = test::sample_dwell();
    dwell.index = index;
    dwell.state = state;
    return to_json(dwell, rig, {"", "", "2026-07-01T10:12:00Z"});
  }
  void list(const std::string& file, const std::string& state, bool linked = false) {
    record::ListedRun listed;
    listed.run = 17;
    listed.file = file;
    listed.state = state;
    listed.linked = linked;
    runs = std::make_shared<const record::ListedRuns>(record::ListedRuns{listed});
  }
  HttpReply ask(const std::string& path, const std::string& query = {}) {
    ServiceView now{rig, info, snapshot};
    now.recording.state = recorder;
    now.recording.runs = runs;
    HttpReply reply = dwells->answer(now, "/api/v1/runs/" + path, query);
    return reply.later ? reply.later() : reply;
  }
  Json asked(const std::string& path, const std::string& query = {}) {
    const HttpReply reply = ask(path, query);
    if (reply.status != 200) throw std::runtime_error(reply.body);
    return Json::parse(reply.body, nullptr, false);
  }
  void expect_error(int status, const std::string& path, const std::string& reason) {
    const HttpReply reply = ask(path);
    EXPECT_EQ(reply.status, status) << path << reply.body;
    EXPECT_NE(reply.body.find(reason), std::string::npos) << reply.body;
    EXPECT_EQ(reply.body.find(folder.path("")), std::string::npos) << "tells where files lie: " << reply.body;
  }

  static constexpr const char* kFile = "bench-17-20260701T101200Z.dwell";
  const std::string at = std::string(kFile) + "/dwells";
  const record::Scratch folder;
  const record::SigningKey key = record::sample_key("bench");
  Rig rig = test::sample_rig();
  RunInfo info;
  Snapshot snapshot;
  record::SampleRun run;
  record::RecorderState recorder;
  std::shared_ptr<const record::ListedRuns> runs;
  std::optional<RunDwells> dwells{std::in_place, std::chrono::hours(1)};  // sanitizers on a busy machine take minutes
};

TEST_F(RunDwellsTest, TellsTheDwellsThatEndedWithTheVerdictsOfTheFile) {
  write(run, key);
  const Json told = asked(at);
  EXPECT_EQ(test::ApiSchema().faults("run_dwells", told), "");
  EXPECT_EQ(told["run"], 17);
  EXPECT_EQ(told["file"], kFile);
  EXPECT_EQ(told["total"], 3);
  ASSERT_EQ(told["dwells"].size(), 3U);
  EXPECT_EQ(told["dwells"][1]["index"], 2);
  EXPECT_EQ(told["dwells"][1]["model"]["verdict"], "adequate");
  EXPECT_TRUE(told["dwells"][0]["model"].is_null());
  EXPECT_EQ(told["dwells"][0]["limits"][0]["verdict"], "violated");
  EXPECT_EQ(told["dwells"][0]["table"]["channel"], "y0");
  const Json first = asked(at, "from=2&count=1");
  ASSERT_EQ(first["dwells"].size(), 1U);
  EXPECT_EQ(first["next"], 3);

  const Json one = asked(at + "/2");
  EXPECT_EQ(test::ApiSchema().faults("dwell", one), "");
  Json stored = Json::parse(dwell_text(2, State::complete));
  EXPECT_EQ(one["model"]["verdict"], "adequate");
  stored["model"] = one["model"];
  EXPECT_EQ(one, stored) << "otherwise as it is in the file";
}

TEST_F(RunDwellsTest, ADwellKeepsWhatAnyMotionHeldAgainstIt) {
  for (const char* const what : {"any motion: an earlier estimate", "any motion: the chain does not explain y1"}) {
    TransientEstimate estimate;
    estimate.estimate.reason = "the chain does not explain y1";
    estimate.dwell = 2;
    estimate.objection = what;
    run.models.push_back(stored_model(std::make_shared<const TransientEstimate>(estimate), rig));
    run.models.back().utc = "2026-07-01T10:12:11Z";
  }
  write(run, key);
  EXPECT_EQ(asked(at)["dwells"][1]["model"]["objection"], "any motion: the chain does not explain y1");
  EXPECT_EQ(asked(at)["dwells"][1]["model"]["verdict"], "adequate");
  EXPECT_TRUE(asked(at)["dwells"][0]["model"].is_null());
}

TEST_F(RunDwellsTest, ARunThatWasCutOffIsReadAsFarAsItGoes) {
  run.closed = false;
  write(run, key);
  list(kFile, "cut off");
  EXPECT_EQ(asked(at)["dwells"].size(), 3U);
}

TEST_F(RunDwellsTest, AFileIsReadOnceUntilItChanges) {
  write(run, key);
  ASSERT_EQ(asked(at)["dwells"].size(), 3U);
  const auto time = std::filesystem::last_write_time(run.path);
  const auto size = std::filesystem::file_size(run.path);
  folder.write(kFile, std::string(size, 'x'));
  std::filesystem::last_write_time(run.path, time);
  EXPECT_EQ(asked(at)["dwells"].size(), 3U) << "not read again";
  expect_error(409, at + "/2", "cannot be read");
  folder.write(kFile, "x");
  expect_error(409, at, "the run's file cannot be read: " + std::string(kFile) + ": ");
}

TEST_F(RunDwellsTest, AnEntryThatIsNoDwellIsTheReason) {
  run.results[3].dwell = R"({"index":2,"state":"complete"})";
  write(run, key);
  expect_error(409, at, "dwell object: ");
  expect_error(409, at + "/1", "dwell object: ");
}

TEST_F(RunDwellsTest, AHostileFileIsKeptInBounds) {
  run.results.clear();
  for (int index = 1; index <= 1100; ++index)
    run.results.push_back({static_cast<std::uint64_t>(index), true, dwell_text(index, State::complete)});
  write(run, key);
  const Json told = asked(at);
  EXPECT_EQ(told["total"], 1100);
  EXPECT_GE(told["forgotten"], 100);
  EXPECT_EQ(told["dwells"].size(), 100U);
  EXPECT_EQ(told["dwells"].back()["index"], 1100);
  expect_error(404, at + "/1", "dwellctl show FILE has all");
}

TEST_F(RunDwellsTest, AFileThatTakesTooLongToReadIsRefused) {
  write(run, key);
  dwells.emplace(std::chrono::seconds(0));
  expect_error(409, at, "the run's file cannot be read: reading it takes more than 0 s");
}

// Descending, so that each is the first to be dropped.
TEST_F(RunDwellsTest, AHostileFilesObjectionsAreKeptInBounds) {
  for (int dwell = 1200; dwell > 0; --dwell) {
    TransientEstimate estimate;
    estimate.estimate.reason = "none";
    estimate.dwell = dwell;
    estimate.objection = std::string(8000, 'x');
    run.models.push_back(stored_model(std::make_shared<const TransientEstimate>(estimate), rig));
    run.models.back().utc = "2026-07-01T10:12:11Z";
  }
  write(run, key);
  const Json told = asked(at);
  EXPECT_EQ(told["dwells"].size(), 3U);
  EXPECT_TRUE(told["dwells"][0]["model"].is_null()) << "dropped: 4 MB hold the newest 500";
}

TEST_F(RunDwellsTest, AnObjectionThatCannotBeReadIsTheReason) {
  TransientEstimate estimate;
  estimate.dwell = 2;
  estimate.objection = "any motion: …";
  run.models.push_back(stored_model(std::make_shared<const TransientEstimate>(estimate), rig));
  run.models.back().utc = "2026-07-01T10:12:11Z";
  std::string& result = run.models.back().result;
  result.replace(result.find("\"dwell\":2"), 9, "\"dwell\":-2");
  write(run, key);
  expect_error(409, at, "objection: dwell: expected an integer from 0 to 1e9");
}

TEST_F(RunDwellsTest, WhatIsNoRunOfTheListIsNotOpened) {
  write(run, key);
  expect_error(404, "other-1-20260701T101200Z.dwell/dwells", "no run of this name");
  expect_error(404, "..%2f..%2fetc%2fpasswd/dwells", "no run of this name");
  expect_error(404, std::string(kFile) + "/else", "expected ");
  expect_error(404, at + "/x", "expected ");
  expect_error(404, at + "/4", "no dwell of this run with the index 4");
  EXPECT_EQ(ask(at, "count=101").status, 400);
  EXPECT_EQ(ask(at + "/1", "count=1").status, 400);
  list(kFile, "recording");
  expect_error(409, at, "the run goes on");
  list(kFile, "closed", true);
  expect_error(409, at, "a link");
}

TEST(RunDwellsPath, IsToldApartFromTheFileItself) {
  EXPECT_FALSE(RunDwells::is_asked("/api/v1/runs"));
  EXPECT_FALSE(RunDwells::is_asked("/api/v1/runs/a.dwell"));
  EXPECT_TRUE(RunDwells::is_asked("/api/v1/runs/a.dwell/dwells"));
  EXPECT_TRUE(RunDwells::is_asked("/api/v1/runs/a.dwell/dwells/3"));
}

}  // namespace
}  // namespace dwell
