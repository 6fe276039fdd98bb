#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "drivers/replay/csv_recording.hpp"

namespace dwell {
namespace {

std::string error_of(const std::string& text) {
  const auto recording = parse_csv(text, "a.csv");
  return recording ? "" : recording.error();
}

TEST(CsvRecording, ReadsWideRowsAndSkipsEmptyCells) {
  const auto recording = parse_csv("t,y0,y1\n0,1,2\n0.5,,-3e-3\n1,4,\n", "a.csv");
  ASSERT_TRUE(recording) << recording.error();
  EXPECT_EQ(recording->channels, (std::vector<std::string>{"y0", "y1"}));
  ASSERT_EQ(recording->samples.size(), 4U);
  EXPECT_EQ(recording->samples[2].t_s, 0.5);
  EXPECT_EQ(recording->samples[2].value, -3e-3);
  EXPECT_EQ(recording->samples[2].column, 1);
  EXPECT_EQ(recording->samples[3].column, 0);
}

TEST(CsvRecording, ReadsLongRowsInTheOrderOfTime) {
  const auto recording = parse_csv("t,channel,value\n1,b,10\n2,b,20\n0.5,a,1\n1,a,2\n", "a.csv");
  ASSERT_TRUE(recording) << recording.error();
  EXPECT_EQ(recording->channels, (std::vector<std::string>{"b", "a"}));
  std::string order;
  for (const auto& sample : recording->samples) order += std::to_string(static_cast<int>(sample.value)) + " ";
  EXPECT_EQ(order, "1 10 2 20 ");
}

TEST(CsvRecording, ToleratesWhatSpreadsheetsAndPeopleAdd) {
  const auto recording =
      parse_csv("\xEF\xBB\xBF# bench 2\r\n t , y0 \r\n 0 ,\t+1.5 \r\n# a note\r\n1,2\r\n\r\n\r\n", "a.csv");
  ASSERT_TRUE(recording) << recording.error();
  EXPECT_EQ(recording->channels, std::vector<std::string>{"y0"});
  ASSERT_EQ(recording->samples.size(), 2U);
  EXPECT_EQ(recording->samples[0].value, 1.5);
}

TEST(CsvRecording, ReadsALastLineWithoutItsEnd) { EXPECT_EQ(error_of("t,y\n0,1\n1,2"), ""); }

TEST(CsvRecording, TellsWhereAMistakeIsAndWhatWasExpected) {
  EXPECT_EQ(error_of("t,y\n0,1\n1,x\n"), "a.csv:3:3: the value is `x`; expected a number");
  EXPECT_EQ(error_of("t,y\n0,nan\n"), "a.csv:2:3: the value is `nan`; expected a finite number");
  EXPECT_EQ(error_of("t,y\n0,1e999\n"), "a.csv:2:3: the value is `1e999`; expected a finite number");
  EXPECT_EQ(error_of("t,y\n0,1,2\n"), "a.csv:2:5: the row goes on; expected 2 cells");
  EXPECT_EQ(error_of("t,y,z\n0,1\n"), "a.csv:2:4: the row ends after 2 cells; expected 3");
  EXPECT_EQ(error_of("t,y\n0,1\n0,2\n"),
            "a.csv:3:1: t is `0` and does not advance; expected more than in the row before");
  EXPECT_EQ(error_of("t,y,y\n0,1,2\n"), "a.csv:1:5: the channel `y` is there twice");
  EXPECT_EQ(error_of("t,channel,value\n1,a,1\n0,a,2\n"),
            "a.csv:3:1: t is `0` and goes back; expected at least that of the sample before of `a`");
  EXPECT_EQ(error_of("time,y\n0,1\n"),
            "a.csv:1:1: the header begins with `time`; expected `t,NAME,…` or `t,channel,value`");
  EXPECT_EQ(error_of(""), "a.csv:1:1: the recording is empty; expected a header `t,NAME,…` or `t,channel,value`");
  EXPECT_EQ(error_of("t,y\n1e12,1\n"), "a.csv:2:1: t is `1e12`; expected seconds, at most 9e9");
  EXPECT_EQ(error_of("t,y\n,1\n"), "a.csv:2:1: t is missing; expected a number");
}

TEST(CsvRecording, RefusesWhatWouldGrowWithoutBound) {
  std::string header = "t";
  for (std::size_t i = 0; i <= kCsvMaxChannels; ++i) header += ",c" + std::to_string(i);
  EXPECT_NE(error_of(header + "\n").find("too many columns"), std::string::npos);
  EXPECT_EQ(error_of("t,y\n" + std::string(kCsvMaxLine + 1, '1')),
            "a.csv:2:1: the line is too long; at most 1 MiB is read");
}

TEST(CsvRecording, ReadsAFileAsItReadsMemory) {
  const auto path = (std::filesystem::temp_directory_path() / ("dwell-csv-" + std::to_string(::getpid()))).string();
  std::string text = "t,y0,y1\n";
  for (int i = 0; i < 200'000; ++i) text += std::to_string(i) + "," + std::to_string(i % 7) + ",0.25\n";
  ASSERT_GT(text.size(), 2 * kCsvMaxLine);
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
  const auto read = read_csv(path);
  const auto parsed = parse_csv(text, path);
  std::filesystem::remove(path);
  ASSERT_TRUE(read && parsed);
  ASSERT_EQ(read->samples.size(), parsed->samples.size());
  for (std::size_t i = 0; i < read->samples.size(); ++i) ASSERT_EQ(read->samples[i].value, parsed->samples[i].value);
  EXPECT_EQ(read_csv(path).error(), path + ":1:1: cannot be read: No such file or directory");
}

TEST(CsvRecording, GivesUpALineOfAFileThatDoesNotEnd) {
  const auto path = (std::filesystem::temp_directory_path() / ("dwell-zeros-" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary) << "t,y\n" << std::string(3 * kCsvMaxLine, '1');
  EXPECT_EQ(read_csv(path).error(), path + ":2:1: the line is too long; at most 1 MiB is read");
  std::filesystem::remove(path);
}

TEST(CsvRecording, ANamedPipeInItsPlaceIsRefusedAndNotWaitedFor) {
  const auto path = (std::filesystem::temp_directory_path() / ("dwell-pipe-" + std::to_string(::getpid()))).string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  ::alarm(60);  // ends the test should it wait for a writer
  EXPECT_EQ(read_csv(path).error(), path + ":1:1: is no regular file; expected a recording in a file");
  ::alarm(0);
  std::filesystem::remove(path);
}

RC_GTEST_PROP(CsvRecording, ReturnsEveryNumberThatWasWritten, (std::vector<double> values)) {
  std::string text = "t,y\n";
  std::vector<double> finite;
  for (const double value : values) {
    char line[64];
    std::snprintf(line, sizeof line, "%zu,%.17g\n", finite.size(), value);
    text += line;
    finite.push_back(value);
  }
  if (finite.empty()) return;
  const auto recording = parse_csv(text, "a.csv");
  RC_ASSERT(recording.has_value());
  RC_ASSERT(recording->samples.size() == finite.size());
  for (std::size_t i = 0; i < finite.size(); ++i) RC_ASSERT(recording->samples[i].value == finite[i]);
}

RC_GTEST_PROP(CsvRecording, SurvivesAnyBytes, (std::string text)) {
  for (const char* header : {"", "t,a,b\n", "t,channel,value\n"}) {
    const auto recording = parse_csv(header + text, "a.csv");
    if (recording)
      for (const auto& sample : recording->samples)
        RC_ASSERT(std::isfinite(sample.value) && sample.column < recording->channels.size());
  }
}

}  // namespace
}  // namespace dwell
