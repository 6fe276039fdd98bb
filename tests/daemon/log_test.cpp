#include "daemon/log/log.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "daemon/log/log_payload.hpp"

namespace dwell {
namespace {

struct LogTest : testing::Test {
  void SetUp() override {
    char name[] = "/tmp/dwell-log-XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder); }
  [[nodiscard]] LogOptions options() const {
    LogOptions to_file;
    to_file.console = false;
    to_file.file = folder + "/dwelld.log";
    return to_file;
  }
  [[nodiscard]] std::string text() const {
    std::ostringstream all;
    all << std::ifstream(folder + "/dwelld.log").rdbuf();
    return all.str();
  }
  std::string folder;
};

TEST_F(LogTest, WritesEveryLineBeforeItEnds) {
  {
    auto log = Log::make(options());
    ASSERT_TRUE(log) << log.error();
    for (int i = 0; i < 100; ++i) (*log)->info("line " + std::to_string(i));
    EXPECT_EQ((*log)->stats().lines, 100u);
  }
  EXPECT_NE(text().find("line 0\n"), std::string::npos);
  EXPECT_NE(text().find("line 99\n"), std::string::npos);
}

TEST_F(LogTest, FieldsAreForTheJournalAlone) {
  {
    auto log = Log::make(options());
    ASSERT_TRUE(log);
    (*log)->warning("stale", {{"DWELL_DEVICE", "amplifier"}});
  }
  EXPECT_NE(text().find("warning stale\n"), std::string::npos) << text();
  EXPECT_EQ(text().find("DWELL_DEVICE"), std::string::npos);
}

TEST_F(LogTest, OfAChangeOfStateTheStateIsKeptWithTheLine) {
  auto log = Log::make(options());
  ASSERT_TRUE(log);
  (*log)->info("state idle -> settling", {{kStateField, "settling"}});
  (*log)->info("state of the art", {{"DWELL_DEVICE", "amplifier"}});
  EXPECT_EQ((*log)->newest().newest(2)[0].state, "settling");
  EXPECT_EQ((*log)->newest().newest(2)[1].state, "");
}

TEST_F(LogTest, ADeviceCannotForgeALine) {
  {
    auto log = Log::make(options());
    ASSERT_TRUE(log);
    (*log)->info(
        "reason: x\n2026-01-01 error all is lost\x1f"
        "MESSAGE=forged {} %s");
  }
  const std::string all = text();
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 1) << all;
  EXPECT_NE(all.find("forged {} %s"), std::string::npos) << "braces are text, not a format";
}

TEST_F(LogTest, WhenLinesComeTooFastTheOldestGoAndAreCounted) {
  LogOptions small = options();
  small.queue = 4;
  auto log = Log::make(small);
  ASSERT_TRUE(log);
  for (int i = 0; i < 20'000; ++i) (*log)->info("a line among very many");
  const LogStats stats = (*log)->stats();
  log->reset();
  const std::string all = text();
  const auto written = static_cast<std::uint64_t>(std::count(all.begin(), all.end(), '\n'));
  EXPECT_EQ(stats.lines, 20'000u);
  EXPECT_EQ(written + stats.dropped, stats.lines);
}

// Until the lines handed in have been written, or not.
LogStats settled(const Log& log, bool failing) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (log.stats().failing != failing && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  return log.stats();
}

// What the manual says of the file: it is rotated at a size, and so many older ones are kept.
struct RotatedLogTest : LogTest {
  static constexpr std::size_t kBytes = 4096, kFiles = 3;
  static constexpr std::size_t kLine = 64;  // more than the longest line here

  // Writes lines "line 0" … and returns those found in the files, from the oldest file to the current one.
  std::vector<int> written(int lines, const LogOptions& options) {
    auto log = Log::make(options);
    EXPECT_TRUE(log) << log.error();
    for (int i = 0; i < lines; ++i) {
      (*log)->info("line " + std::to_string(i));
      // No faster than they are written: this is about the file, not about the queue.
      if (i % 1000 == 999) await(i);
    }
    EXPECT_EQ((*log)->stats().lines, static_cast<std::uint64_t>(lines));
    EXPECT_EQ((*log)->stats().dropped, 0u);
    log->reset();
    std::vector<int> found;
    for (const std::string& file : files_from_the_oldest()) {
      std::ifstream text(file);
      for (std::string line; std::getline(text, line);) found.push_back(std::stoi(line.substr(line.rfind(' '))));
    }
    return found;
  }
  [[nodiscard]] std::vector<std::string> files_from_the_oldest() const {
    std::vector<std::string> files;
    for (std::size_t i = 9; i > 0; --i)
      if (const auto older = folder + "/dwelld." + std::to_string(i) + ".log"; std::filesystem::exists(older))
        files.push_back(older);
    files.push_back(folder + "/dwelld.log");
    return files;
  }
  void await(int line) const {
    const std::string last = "line " + std::to_string(line) + "\n";
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (text().find(last) == std::string::npos && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  }
  [[nodiscard]] LogOptions rotated() const {
    LogOptions small = options();
    small.file_bytes = kBytes;
    small.files = kFiles;
    return small;
  }
};

TEST_F(RotatedLogTest, WhatFindsRoomInTheFilesIsAllThereInItsOrder) {
  const std::vector<int> found = written(200, rotated());
  std::vector<int> all(200);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(found, all);
  EXPECT_GT(files_from_the_oldest().size(), 1u) << "it was rotated";
}

TEST_F(RotatedLogTest, FilesAreBoundedInSizeAndNumberAndOnlyTheOldestLinesGo) {
  const int lines = 5000;
  const std::vector<int> found = written(lines, rotated());
  const std::vector<std::string> files = files_from_the_oldest();
  EXPECT_EQ(files.size(), kFiles + 1) << "so many older ones, and the current one";
  std::size_t there = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    ++there;
    EXPECT_LE(entry.file_size(), kBytes) << entry.path();
  }
  EXPECT_EQ(there, files.size()) << "and nothing else";
  for (std::size_t i = 0; i + 1 < files.size(); ++i)
    EXPECT_GT(std::filesystem::file_size(files[i]), kBytes - kLine) << files[i] << " was full when it was rotated";
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.back(), lines - 1);
  for (std::size_t i = 1; i < found.size(); ++i) ASSERT_EQ(found[i], found[i - 1] + 1) << "no line is missing between";
}

TEST_F(RotatedLogTest, TheManualSaysHowLargeTheFilesGrowAndHowManyAreKept) {
  std::ostringstream manual;
  manual << std::ifstream(DWELL_SOURCE "/docs/man/dwelld.8").rdbuf();
  const LogOptions served;
  EXPECT_EQ(served.files, 5u) << "the manual says five";
  const std::string size = std::to_string(served.file_bytes >> 20), all = std::to_string(served.file_bytes * 6 >> 20);
  EXPECT_NE(
      manual.str().find("rotated at " + size + " MiB; five older ones are kept beside it, " + all + " MiB in all"),
      std::string::npos);
}

TEST_F(RotatedLogTest, AServiceThatBeginsAnewWritesOnWhereItStopped) {
  (void)written(10, rotated());
  const std::vector<int> found = written(10, rotated());
  ASSERT_EQ(found.size(), 20u);
  EXPECT_EQ(found[9], 9);
  EXPECT_EQ(found[10], 0);
}

TEST_F(LogTest, AFullDiskIsToldWithTheNumberOfLinesLost) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "there is no /dev/full to write to";
  LogOptions full = options();
  full.file = "/dev/full";
  auto log = Log::make(full);
  ASSERT_TRUE(log) << log.error();
  EXPECT_FALSE((*log)->stats().failing);
  for (int i = 0; i < 29; ++i) (*log)->info("a line that finds no room");
  EXPECT_NE(settled(**log, true).reason.find("No space left"), std::string::npos) << (*log)->stats().reason;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while ((*log)->stats().dropped < 29 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_EQ((*log)->stats().dropped, 29u);
}

TEST_F(LogTest, AFileThatCannotBeOpenedIsSaid) {
  LogOptions impossible = options();
  impossible.file = "/proc/no/such/folder/dwelld.log";
  const auto log = Log::make(impossible);
  ASSERT_FALSE(log);
  EXPECT_NE(log.error().find("/proc/no/such"), std::string::npos) << log.error();
}

TEST(Journal, IsRecognizedByDeviceAndInodeAlone) {
  struct stat is {};
  ASSERT_EQ(fstat(STDOUT_FILENO, &is), 0);
  const std::string right = std::to_string(is.st_dev) + ":" + std::to_string(is.st_ino);
  EXPECT_TRUE(is_journal(right.c_str(), STDOUT_FILENO));
  EXPECT_FALSE(is_journal((right + "1").c_str(), STDOUT_FILENO));
  EXPECT_FALSE(is_journal(nullptr, STDOUT_FILENO));
  for (const char* wrong : {"", ":", "8", "8:", "x:y", "1:2:3"})
    EXPECT_FALSE(is_journal(wrong, STDOUT_FILENO)) << wrong;
}

TEST(LogPayload, CarriesFieldsBehindTheMessage) {
  const std::string payload = make_payload(
      "m\x1f"
      "A=b",
      {{"DWELL_DEVICE", "d\n"}});
  EXPECT_EQ(message_of(payload), "m A=b");
  EXPECT_EQ(payload, std::string("m A=b\x1f"
                                 "DWELL_DEVICE=d "));
}

TEST(LogPayload, CarriesNoControlOfTheTerminalNorOfTheWritingDirection) {
  EXPECT_EQ(make_payload("a\u009Bb\u202Ec", {{"DWELL_DEVICE", "d\u2066"}}), std::string("a b c\x1f"
                                                                                        "DWELL_DEVICE=d "));
}

}  // namespace
}  // namespace dwell
