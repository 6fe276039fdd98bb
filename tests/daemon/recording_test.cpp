#include "daemon/run/recording.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "config/sha256.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/daemon/log_to_read.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace dwell {
namespace {

struct RecordingTest : testing::Test {
  RecordingTest() : directory(testing::TempDir() + "recording-test-" + std::to_string(getpid())) {
    std::filesystem::create_directories(directory);
    file.path = "rig.toml";
    file.directory = directory;
    file.recording.on = true;
    file.recording.directory = directory + "/runs";
    file.rig.name = "bench";
    file.devices.emplace_back();
  }
  ~RecordingTest() override { std::filesystem::remove_all(directory); }
  RecordingTest(const RecordingTest&) = delete;
  RecordingTest& operator=(const RecordingTest&) = delete;

  // Named by the rig file.
  void name(const std::string& name, std::size_t bytes) {
    std::ofstream(directory + "/" + name) << std::string(bytes, 'x');
    file.devices[0].entries.push_back({"dbc", name});
  }

  // Records a run of some seconds by the recorder that the service makes, and opens its file.
  record::RunReader recorded(const config::SchemaSource& drivers = {}) {
    {
      const auto recorder = make_recorder(file, drivers, log);
      EXPECT_TRUE(recorder) << recorder.error();
      record::SyntheticStream stream(2, 100.0, [&](const Record& record) { (*recorder)->record(record); });
      stream.starts();
      stream.play(1.5);
    }
    for (const auto& entry : std::filesystem::directory_iterator(file.recording.directory))
      if (entry.path().extension() == ".dwell") return std::move(*record::RunReader::open(entry.path()));
    throw std::runtime_error("no run was recorded");
  }

  // Runs in the directory, each with its age known.
  void record_runs(int count) const {
    record::Notices notices;
    for (int i = 0; i < count; ++i) {
      record::Recorder recorder(record::recorder_options(file.recording.directory, notices));
      record::SyntheticStream stream(2, 100.0, [&](const Record& record) { recorder.record(record); });
      stream.starts();
      stream.play(1.5);
    }
  }
  [[nodiscard]] std::size_t runs() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(file.recording.directory))
      count += entry.path().extension() == ".dwell" ? 1 : 0;
    return count;
  }
  [[nodiscard]] bool said(const std::string& text) {
    const auto lines = static_cast<Log&>(log).newest().newest(NewestLines::kLines);
    return std::any_of(lines.begin(), lines.end(),
                       [&](const LogLine& line) { return line.text.find(text) != std::string::npos; });
  }

  std::string directory;
  config::RigFile file;
  test::LogToRead log{"recording-test"};
};

// Waits for another thread; false: not within 20 s.
template <class Condition>
bool comes(const Condition& condition) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < until) {
    if (condition()) return true;
    std::this_thread::yield();
  }
  return false;
}

std::size_t heads_in(const std::string& path) {
  std::ifstream lines(path);
  std::size_t heads = 0;
  for (std::string line; std::getline(lines, line);) heads += line.find(" dwell/run/") != std::string::npos ? 1 : 0;
  return heads;
}

TEST_F(RecordingTest, FilesThatNoReaderCouldReadBackAreRefusedBeforeTheFirstRun) {
  name("motor.dbc", 4 << 20);
  name("shaker.dbc", (4 << 20) - 1000);
  const auto recorder = make_recorder(file, {}, log);
  ASSERT_FALSE(recorder);
  EXPECT_EQ(recorder.error().find("rig.toml: "), 0u) << recorder.error();
  EXPECT_NE(recorder.error().find("motor.dbc (4194304 bytes) shaker.dbc (4193304 bytes)"), std::string::npos)
      << recorder.error();
}

TEST_F(RecordingTest, AFileThatIsNamedTwiceIsKeptOnce) {
  name("motor.dbc", 4 << 20);
  name("motor.dbc", 4 << 20);
  const auto recorder = make_recorder(file, {}, log);
  EXPECT_TRUE(recorder) << recorder.error();
}

dwell_driver_table driver_of_version(const char* version) {
  dwell_driver_table table{};
  table.version = version;
  return table;
}

TEST_F(RecordingTest, ARunsFileHoldsTheFilesThatTheRigFileNamesThePluginsAndTheTimeZone) {
  const std::string dbc = "VERSION \"\"\nBU_: amplifier\n", chain = "BO_ 385 motor: 8 amplifier\n";
  std::ofstream(directory + "/motor.dbc") << dbc;
  std::ofstream(directory + "/shaker.dbc") << chain;
  std::ofstream(directory + "/empty.dbc") << "";
  file.text = "[rig]\nname = \"bench\"\n";
  file.sha256 = config::sha256(file.text);
  file.devices[0].driver = "can";
  file.devices[0].entries = {{"dbc", "motor.dbc"}, {"host", "192.0.2.10"}};
  file.devices[0].channels.emplace_back().entries = {{"dbc", "shaker.dbc"}, {"more", "empty.dbc"}};
  file.devices.emplace_back().driver = "modbus";
  setenv("TZ", "Europe/Berlin", 1);
  const dwell_driver_table can = driver_of_version("1.2.3"), modbus = driver_of_version("0.4");
  const record::RunHeader header =
      recorded([&](std::string_view driver) -> tl::expected<const dwell_driver_table*, std::string> {
        return driver == "can" ? &can : &modbus;
      }).header();
  unsetenv("TZ");
  EXPECT_EQ(header.rig.text, file.text);
  EXPECT_EQ(header.rig.sha256, file.sha256);
  ASSERT_EQ(header.files.size(), 3u);
  EXPECT_EQ(header.files[0].path, "motor.dbc");
  EXPECT_EQ(header.files[0].text, dbc);
  EXPECT_EQ(header.files[0].sha256, config::sha256(dbc));
  EXPECT_EQ(header.files[1].text, chain) << "named by a channel";
  EXPECT_EQ(header.files[2].sha256, config::sha256(""));
  EXPECT_TRUE(header.files[2].holds_text()) << "there was nothing in it";
  ASSERT_EQ(header.plugins.size(), 2u);
  EXPECT_EQ(header.plugins[0].driver, "can");
  EXPECT_EQ(header.plugins[0].version, "1.2.3");
  EXPECT_EQ(header.plugins[1].version, "0.4");
  EXPECT_EQ(header.origin.time_zone, "Europe/Berlin");
  EXPECT_FALSE(header.origin.host.empty());
  EXPECT_FALSE(header.origin.build.empty());
}

TEST_F(RecordingTest, OfAFileAboveFourMebibytesTheHashIsKeptAndTheLogSaysThatTheTextIsNot) {
  const std::size_t bytes = (4 << 20) + 1;
  name("tape.csv", bytes);
  const record::RunHeader header = recorded().header();
  ASSERT_EQ(header.files.size(), 1u);
  EXPECT_EQ(header.files[0].path, "tape.csv");
  EXPECT_EQ(header.files[0].sha256, config::sha256(std::string(bytes, 'x')));
  EXPECT_EQ(header.files[0].text, "");
  EXPECT_FALSE(header.files[0].holds_text());
  EXPECT_EQ(log.lines().at(0),
            "info " + directory + "/tape.csv has 4 MB: run files will hold its SHA-256, not its text");
}

TEST_F(RecordingTest, OfFilesBeyondAGibibyteTheNameAloneIsKeptAndTheLogWarns) {
  for (const char* name : {"long.csv", "short.csv"}) {
    std::ofstream(directory + "/" + name) << "";
    file.devices[0].entries.push_back({"file", std::string(name)});
  }
  std::filesystem::resize_file(directory + "/long.csv", (1u << 30) + 1);  // of holes, which take no room
  std::filesystem::resize_file(directory + "/short.csv", 5u << 20);
  const record::RunHeader header = recorded().header();
  ASSERT_EQ(header.files.size(), 2u);
  EXPECT_EQ(header.files[0].sha256, "");
  EXPECT_FALSE(header.files[0].holds_text());
  EXPECT_EQ(header.files[1].sha256, config::sha256(std::string(5u << 20, '\0'))) << "it still finds room";
  EXPECT_EQ(
      log.lines().at(0),
      "warning " + directory + "/long.csv has 1073 MB: run files will hold its name, neither its text nor its SHA-256");
}

TEST_F(RecordingTest, HeadsGoToTheFileAndToTheCommandThatTheRigFileNames) {
  const std::string to_file = directory + "/heads", by_command = directory + "/sent";
  file.recording.anchor =
      config::AnchorSettings{.minutes = 10.0, .file = to_file, .command = {"/bin/sh", "-c", "cat >>" + by_command}};
  (void)recorded();
  EXPECT_GT(heads_in(to_file), 0u);
  EXPECT_GT(heads_in(by_command), 0u);
}

TEST_F(RecordingTest, HeadsGoThereAsOftenAsTheRigFileAsks) {
  const std::string to_file = directory + "/heads";
  file.recording.anchor = config::AnchorSettings{.minutes = 1e-3, .file = to_file, .command = {}};  // 60 ms
  const auto recorder = make_recorder(file, {}, log);
  ASSERT_TRUE(recorder) << recorder.error();
  record::SyntheticStream stream(2, 100.0, [&](const Record& record) { (*recorder)->record(record); });
  stream.starts();
  for (int i = 0; i < 4; ++i) {
    const std::size_t before = heads_in(to_file);
    stream.play(1.5);
    ASSERT_TRUE(comes([&] { return heads_in(to_file) > before; })) << "the run goes on, and its head is anchored again";
  }
}

TEST_F(RecordingTest, RunsBeyondTheSizeThatTheRigFileAllowsAreDeleted) {
  record_runs(2);
  ASSERT_EQ(runs(), 2u);
  file.recording.retain_gigabytes = 1e-9;
  const auto recorder = make_recorder(file, {}, log);
  ASSERT_TRUE(recorder) << recorder.error();
  EXPECT_TRUE(comes([&] { return runs() == 0; }));
  EXPECT_TRUE(comes([&] { return said(" deleted, "); }));
}

// Where the clock of this computer is not synchronized, the old runs are told instead.
TEST_F(RecordingTest, RunsOlderThanTheRigFileAllowsAreDeletedOrToldWhereNoAgeCanBeBelieved) {
  record_runs(2);
  file.recording.retain_days = 0.0;
  const auto recorder = make_recorder(file, {}, log);
  ASSERT_TRUE(recorder) << recorder.error();
  EXPECT_TRUE(comes([&] { return said("older than 0 days") || said("runs that seem too old to be kept: 2"); }));
}

TEST_F(RecordingTest, WithoutALimitNoRunIsDeletedAndNoneSeemsTooOld) {
  record_runs(2);
  const auto recorder = make_recorder(file, {}, log);
  ASSERT_TRUE(recorder) << recorder.error();
  ASSERT_TRUE(comes([&] { return (*recorder)->runs()->size() == 2; }));
  (*recorder)->finish();
  EXPECT_EQ(runs(), 2u);
  EXPECT_FALSE(said("too old"));
}

}  // namespace
}  // namespace dwell
