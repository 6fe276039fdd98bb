// What the log says of one device.
#include "daemon/estimate/device_lines.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/durations.hpp"

namespace dwell {
namespace {

struct DeviceLinesTest : testing::Test {
  DeviceLinesTest() {
    LogOptions to_file;
    to_file.console = false;
    to_file.file = path;
    log = std::move(*Log::make(to_file));
    lines.emplace("amplifier", 100.0, *log);
  }
  ~DeviceLinesTest() override { std::remove(path.c_str()); }

  // Everything written so far, without its dates.
  std::vector<std::string> written() {
    lines.reset();
    log.reset();
    std::ifstream file(path);
    std::vector<std::string> out;
    for (std::string line; std::getline(file, line);) {
      const std::size_t at = line.find("device amplifier");
      if (at != std::string::npos) out.push_back(line.substr(at));
    }
    return out;
  }

  std::string path = testing::TempDir() + "device_lines_" + std::to_string(getpid()) + ".log";
  std::unique_ptr<Log> log;
  std::optional<DeviceLines> lines;
};

TEST_F(DeviceLinesTest, ChannelsThatGoStaleTogetherAreOneLineWithTheReason) {
  lines->stale({"y0", "y1"}, Fault::silent, "its driver hangs", 1, 5 * kSecond_ns);
  EXPECT_EQ(written(), std::vector<std::string>{"device amplifier: y0, y1 stale, silent: its driver hangs"});
}

TEST_F(DeviceLinesTest, AReasonThatIsTheFaultItselfIsNotSaidTwice) {
  lines->stale({"y0"}, Fault::timeout, "timeout", 3, 5 * kSecond_ns);
  EXPECT_EQ(written(), std::vector<std::string>{"device amplifier: y0 stale, timeout (3 times by now)"});
}

TEST_F(DeviceLinesTest, AFaultThatGoesOnIsWrittenMoreAndMoreRarelyWithItsCount) {
  for (std::int64_t second = 1; second <= 60; ++second)
    lines->counted(Fault::timeout, static_cast<std::uint64_t>(10 * second), second * kSecond_ns);
  const auto out = written();
  ASSERT_GT(out.size(), 3U);
  EXPECT_LT(out.size(), 10U);
  EXPECT_EQ(out[0], "device amplifier: timeout (10 times by now)");
}

TEST_F(DeviceLinesTest, WhatALineHasToldOfIsNotToldAgain) {
  lines->stale({"y0"}, Fault::timeout, "timeout", 1, 5 * kSecond_ns);
  for (std::int64_t second = 6; second <= 600; ++second) lines->counted(Fault::timeout, 1, second * kSecond_ns);
  EXPECT_EQ(written().size(), 1U);
}

TEST_F(DeviceLinesTest, OneFaultDoesNotKeepAnotherQuiet) {
  for (std::int64_t i = 1; i <= 100; ++i)
    lines->counted(Fault::timeout, static_cast<std::uint64_t>(i), kSecond_ns + i * 1'000'000);
  lines->counted(Fault::bad_checksum, 1, 2 * kSecond_ns);
  const auto out = written();
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[1].substr(0, 29), "device amplifier: bad checksu");
}

TEST_F(DeviceLinesTest, RecoveriesOfALoosePlugDoNotFillTheLog) {
  lines->delivering({"y0"}, true, 0, kSecond_ns);
  for (std::int64_t i = 0; i < 100; ++i)
    lines->delivering({"y0"}, false, kSecond_ns / 2, 2 * kSecond_ns + i * 100'000'000);
  const auto out = written();
  EXPECT_EQ(out[0], "device amplifier: y0 delivering");
  EXPECT_NE(out[1].find("y0 delivering again after 0.5 s"), std::string::npos) << out[1];
  EXPECT_LT(out.size(), 8U);
}

TEST_F(DeviceLinesTest, ARateThatCannotBeKeptIsToldWithOneThatCan) {
  for (std::int64_t second = 0; second <= 120; ++second)
    lines->missed_polls(static_cast<std::uint64_t>(25 * second), second * kSecond_ns);
  lines->end(3000);
  const auto out = written();
  ASSERT_GE(out.size(), 2U);
  EXPECT_NE(out[0].find("25 % of its polls"), std::string::npos) << out[0];
  EXPECT_NE(out[0].find("a rate below 75 Hz"), std::string::npos) << out[0];
  EXPECT_NE(out.back().find("3000 polls of this run"), std::string::npos) << out.back();
}

TEST_F(DeviceLinesTest, ARunWithoutSkippedPollsSaysNothingOfThem) {
  lines->missed_polls(0, kSecond_ns);
  lines->end(0);
  EXPECT_TRUE(written().empty());
}

}  // namespace
}  // namespace dwell
