#include "daemon/run/recording.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/daemon/log_to_read.hpp"

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

  std::string directory;
  config::RigFile file;
  test::LogToRead log{"recording-test"};
};

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

}  // namespace
}  // namespace dwell
