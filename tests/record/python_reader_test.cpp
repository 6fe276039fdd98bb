// The independent reader in Python, written from docs/run-file.md alone, against what the record's own code writes.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/signature.hpp"
#include "tests/record/altered_files.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/sample_run.hpp"
#include "tests/record/scratch.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace dwell::record {
namespace {

using PythonJson = nlohmann::json;

struct PythonReader : testing::Test {
  void SetUp() override {
    if (std::system("/usr/bin/python3 -c 'import zstandard, cryptography' 2>/dev/null") != 0)
      GTEST_SKIP() << "python3-zstandard or python3-cryptography is not installed";
    run = sample_run_file(scratch.path("run.dwell"), key, R"({"index":1})");
  }

  struct Found {
    int code = -1;
    PythonJson json;
  };
  // What the reader says of the file.
  [[nodiscard]] Found read(const std::string& options = "--heads") const { return read_file(run.path, options); }
  [[nodiscard]] static Found read_file(const std::string& path, const std::string& options = "--heads") {
    const std::string command = "/usr/bin/python3 " PYTHON_RUN_READER " " + path + " " + options;
    std::FILE* const pipe = popen(command.c_str(), "r");
    std::string text;
    char part[4096];
    for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, pipe)) > 0;) text.append(part, n);
    const int status = pclose(pipe);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, PythonJson::parse(text, nullptr, false)};
  }
  void alter(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(run.path.c_str(), &database), SQLITE_OK);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(database);
  }

  const Scratch scratch;
  const SigningKey key = sample_key("bench2");
  SampleRun run;
};

// The line that the reader writes of it.
std::string line_of(const Record& r) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &r.value, sizeof bits);
  char text[128];
  std::snprintf(text, sizeof text, "%lld,%lld,%016llx,%u,%u,%u,%u", static_cast<long long>(r.t_ns),
                static_cast<long long>(r.stamped_ns), static_cast<unsigned long long>(bits), r.t_half_ns, r.channel,
                static_cast<unsigned>(r.kind), r.flags);
  return text;
}

TEST_F(PythonReader, IsShorterThan250Lines) {
  std::ifstream file(PYTHON_RUN_READER);
  int lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  EXPECT_GT(lines, 100);
  EXPECT_LT(lines, 250);
}

TEST_F(PythonReader, ReadsEveryRecordToTheLastBitAndEveryHead) {
  write(run, key);
  const Found found = read("--heads --records " + scratch.path("records.csv") + " --key " + run.header.vkey);
  ASSERT_EQ(found.code, 0) << found.json;
  EXPECT_EQ(found.json["state"], "intact");
  EXPECT_EQ(found.json["records"], run.stream.size());
  EXPECT_EQ(found.json["samples"], 4000);
  EXPECT_EQ(found.json["run"]["label"], run.header.label);
  EXPECT_EQ(found.json["results"][0]["dwell"]["index"], 1);
  EXPECT_EQ(found.json["events"][1]["text"], run.events[1].text);
  EXPECT_EQ(found.json["end"]["why"], "operator");

  std::istringstream lines(Scratch::read(scratch.path("records.csv")));
  std::string line;
  for (const Record& record : run.stream) {
    ASSERT_TRUE(std::getline(lines, line));
    ASSERT_EQ(line, line_of(record));
  }
  EXPECT_FALSE(std::getline(lines, line));

  auto reader = ChainReader::open(run.path, ChainSort::run);
  ASSERT_TRUE(reader) << reader.error();
  std::vector<std::string> heads;
  for (auto row = reader->next(); row && *row; row = reader->next()) heads.push_back(hex((*row)->head));
  EXPECT_EQ(found.json["heads"].get<std::vector<std::string>>(), heads);
}

TEST_F(PythonReader, ReadsEstimatesAndVerificationsWithWhatTheyWereComputedFrom) {
  run.models = {
      {"verification", 900, "2026-07-01T10:12:09Z", R"({"position":880,"ended":false})", R"({"verdict":"adequate"})"},
      {"estimate", 400, "2026-07-01T10:12:04Z", R"({"last":390,"readings":250})", R"({"motion":null})"}};
  write(run, key);
  const Found found = read();
  ASSERT_EQ(found.code, 0) << found.json;
  EXPECT_EQ(found.json["state"], "intact");
  EXPECT_EQ(found.json["estimates"][0]["position"], 400);
  EXPECT_EQ(found.json["estimates"][0]["from"]["last"], 390);
  EXPECT_EQ(found.json["verifications"][0]["result"]["verdict"], "adequate");

  auto reader = RunReader::open(run.path);
  ASSERT_TRUE(reader) << reader.error();
  std::vector<std::string> kinds;
  ASSERT_TRUE(reader->models([&](const StoredModel& model) { return kinds.push_back(model.kind), true; }));
  EXPECT_EQ(kinds, (std::vector<std::string>{"estimate", "verification"})) << "in the order of their positions";
}

TEST_F(PythonReader, TellsARunThatWasCutOff) {
  run.closed = false;
  write(run, key);
  const Found found = read();
  EXPECT_EQ(found.code, 0) << found.json;
  EXPECT_EQ(found.json["state"], "open");
  EXPECT_EQ(found.json["samples"], 4000);
}

std::vector<std::string> heads_of(const std::string& path) {
  auto reader = ChainReader::open(path, ChainSort::run);
  EXPECT_TRUE(reader) << reader.error();
  std::vector<std::string> heads;
  for (auto row = reader->next(); row && *row; row = reader->next()) heads.push_back(hex((*row)->head));
  return heads;
}

// A kill leaves the newest entries in the -wal alone.
TEST_F(PythonReader, ReadsTheLogBesideAFileThatWasCutOffAndLeavesBothAsTheyWere) {
  const Scratch left;
  const std::string path = left.path("run.dwell");
  write_sample(path, {.seed = 1, .end = SampleEnd::log_left});
  const Files before = files_in(left);
  ASSERT_EQ(before.size(), 2u);
  const Found found = read_file(path);
  ASSERT_EQ(found.code, 0) << found.json;
  EXPECT_EQ(found.json["state"], "open");
  EXPECT_EQ(found.json["samples"], sample_count({}));
  EXPECT_EQ(found.json["heads"].get<std::vector<std::string>>(), heads_of(path));
  EXPECT_EQ(files_in(left), before);
  std::filesystem::remove(path + "-wal");
  EXPECT_NE(read_file(path).json["samples"], sample_count({})) << "they stood in the log";
}

TEST_F(PythonReader, ReadsWhatTheRecorderWroteToTheLastBit) {
  const Scratch runs;
  Notices notices;
  std::vector<Record> handed;
  {
    Recorder recorder(recorder_options(runs.path(), notices));
    SyntheticStream stream(2, 500.0, [&](const Record& record) {
      handed.push_back(record);
      recorder.record(record);
    });
    stream.starts();
    stream.play(3.5);
    recorder.result(stream.position(), true, std::make_shared<const Dwell>());
    // Before, the event would be older than the run.
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!notices.hold("recording run 1") && std::chrono::steady_clock::now() < until) std::this_thread::yield();
    StoredEvent event;
    event.what = "state";
    event.text = "settling";
    recorder.event(std::move(event));
  }
  std::string path;
  for (const auto& entry : std::filesystem::directory_iterator(runs.path()))
    if (entry.path().extension() == ".dwell") path = entry.path();
  const auto reader = RunReader::open(path);
  ASSERT_TRUE(reader) << reader.error();
  const Found found =
      read_file(path, "--heads --records " + scratch.path("records.csv") + " --key " + reader->header().vkey);
  ASSERT_EQ(found.code, 0) << found.json;
  EXPECT_EQ(found.json["state"], "intact");
  EXPECT_EQ(found.json["run"]["run"], 1);
  EXPECT_EQ(found.json["end"]["why"], "service stopped");
  EXPECT_EQ(found.json["end"]["records"], handed.size());
  ASSERT_EQ(found.json["results"].size(), 1u);
  EXPECT_EQ(found.json["results"][0]["dwell"]["index"], 1);
  ASSERT_EQ(found.json["events"].size(), 1u);
  EXPECT_EQ(found.json["events"][0]["text"], "settling");
  EXPECT_EQ(found.json["heads"].get<std::vector<std::string>>(), heads_of(path));
  std::istringstream lines(Scratch::read(scratch.path("records.csv")));
  std::string line;
  for (const Record& record : handed) {
    ASSERT_TRUE(std::getline(lines, line));
    ASSERT_EQ(line, line_of(record));
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(PythonReader, KnowsSignaturesOfBothSorts) {
  write(run, key);
  const SigningKey own = sample_key("anna@desk");
  PersonalSignature words{"Anna Weber", "reviewed", "", "2026-07-02T08:00:00Z", 0, "", Person{1000, "anna"}, "", ""};
  ASSERT_TRUE(sign_by_service(run.path, words, key));
  words.person.reset();
  words.meaning = "approved";
  words.reason = "as agreed";
  ASSERT_TRUE(sign_by_own_key(run.path, words, own));
  const Found found = read();
  ASSERT_EQ(found.code, 0) << found.json;
  ASSERT_EQ(found.json["signatures"].size(), 2u);
  EXPECT_EQ(found.json["signatures"][0]["by"], "the service");
  EXPECT_EQ(found.json["signatures"][1]["by"], own.public_key().vkey());
  // Words put into the person's mouth: the chain is made good, the person's note is not.
  alter(
      "UPDATE entry SET body = CAST(replace(body, 'as agreed', 'gladly') AS BLOB) WHERE seq = (SELECT max(seq) FROM "
      "entry)");
  EXPECT_EQ(read().json["state"], "tampered");
}

TEST_F(PythonReader, FindsWhatWasAltered) {
  for (const char* sql : {
           "UPDATE entry SET body = CAST(replace(body, 'anna', 'carl') AS BLOB) WHERE seq = 1",
           "UPDATE entry SET body = CAST(hex(body) AS BLOB) WHERE seq = 5",
           "UPDATE entry SET body = substr(body, 1, length(body) - 1) WHERE seq = 6",
           "UPDATE entry SET t_ns = t_ns + 1 WHERE seq = 7",
           "UPDATE entry SET kind = 'result' WHERE kind = 'event'",
           "DELETE FROM entry WHERE seq = 6",
           "DELETE FROM entry WHERE kind = 'end'",
           "DELETE FROM note WHERE seq = (SELECT max(seq) FROM note)",
           "UPDATE note SET text = replace(text, 'dwell/run/0', 'dwell/run/1')",
           "UPDATE note SET text = (SELECT text FROM note ORDER BY seq LIMIT 1) WHERE seq = 9",
           "PRAGMA application_id = 1",
           "CREATE TABLE more (a)",
           "CREATE VIEW seen AS SELECT 1",
       }) {
    std::filesystem::remove(run.path);
    write(run, key);
    alter(sql);
    const Found found = read();
    EXPECT_EQ(found.code, 1) << sql;
    EXPECT_EQ(found.json["state"], "tampered") << sql;
    EXPECT_TRUE(found.json["where"].is_string()) << sql;
  }
}

TEST_F(PythonReader, FindsAForgeryByAnotherKeyWhereTheKeyIsPinned) {
  const std::string pinned = run.header.vkey;
  const SigningKey forger = sample_key("bench2");
  run.header.vkey = forger.public_key().vkey();
  write(run, forger);
  EXPECT_EQ(read().code, 0);
  EXPECT_EQ(read("--key " + pinned).code, 1);
}

}  // namespace
}  // namespace dwell::record
