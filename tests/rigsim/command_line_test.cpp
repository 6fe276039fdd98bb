// The options of the command line: each gives the recording of the disturbance that it names, to the last digit.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <sstream>

#include "tests/rigsim/device.hpp"
#include "tests/rigsim/recording.hpp"

namespace rigsim {
namespace {

// What the program prints to standard output; empty: it failed.
std::string program(const std::string& arguments) {
  const std::string command =
      std::string(RIGSIM) + " --csv - --duration 0.3 --rate 100 --noise 0.01 " + arguments + " 2>/dev/null";
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  std::string out;
  char chunk[4096];
  for (std::size_t size = 0; (size = std::fread(chunk, 1, sizeof chunk, pipe)) > 0;) out.append(chunk, size);
  return ::pclose(pipe) == 0 ? out : std::string();
}

std::string recorded(const std::function<void(Options&)>& set) {
  Options options;
  options.faults.noise = 0.01;
  set(options);
  EXPECT_EQ(Device::fault(options), "");
  std::ostringstream out;
  EXPECT_EQ(write_recording(out, options, {.duration_s = 0.3, .rate_hz = 100}), "");
  return out.str();
}

struct Case {
  const char* arguments;
  std::function<void(Options&)> set;
};
std::function<void(Options&)> line(const char* text) {
  return [text](Options& options) { options.lines.emplace_back(text); };
}

TEST(CommandLine, EveryDisturbanceOfReadingsHasItsOption) {
  for (const Case& option :
       {Case{"--refresh 0.03", line("refresh all 0.03")},
        {"--refresh reaction:0.02", line("refresh reaction 0.02")},
        {"--clip y1:-0.1:0.2", line("clip y1 -0.1 0.2")},
        {"--converter reaction:6:1.2", line("converter reaction 6 1.2")},
        {"--converter y1:12:1.2 --low-byte y1:90",
         [](Options& options) {
           options.lines = {"converter y1 12 1.2", "low-byte y1 90"};
         }},
        {"--zeros 0.3", line("zeros all 0.3")},
        {"--zeros y1:0.3", line("zeros y1 0.3")},
        {"--repeats 0.3", line("repeats all 0.3")},
        {"--repeats reaction:0.3", line("repeats reaction 0.3")},
        {"--stale 2", line("stale all 2")},
        {"--stale y2:3", line("stale y2 3")},
        {"--freeze y1:0.2:0.05", line("freeze y1 0.2 0.05")},
        {"--garbage y2:0.5", line("garbage y2 0.5")},
        {"--glitch y1:0.37", line("glitch y1 0.37")},
        {"--glitch y1:0.37:0.2", line("glitch y1 0.37 0.2")},
        {"--scale reaction:-1", line("scale reaction -1")},
        {"--scale y1:0.1:0.25", line("scale y1 0.1 0.25")},
        {"--lag y1:0.02", line("lag y1 0.02")},
        {"--lag y1:0:0.002", line("lag y1 0 0.002")},
        {"--swap y1:y2", line("swap y1 y2")},
        {"--stuck y3", line("stuck y3 on")},
        {"--friction 4:10",
         [](Options& options) {
           options.bend.elements = {{4, 10.0, 0.0}};
         }},
        {"--cubic 2:1e6",
         [](Options& options) {
           options.bend.elements = {{2, 0.0, 1e6}};
         }},
        {"--side-spring 2:ground:500:1",
         [](Options& options) {
           options.bend.side = {{2, -1, 500.0, 1.0}};
         }},
        {"--side-spring 3:1:100",
         [](Options& options) {
           options.bend.side = {{3, 1, 100.0, 0.0}};
         }},
        {"--hunt 0.1:0.5", [](Options& options) { options.bend.hunt = 0.1, options.bend.hunt_hz = 0.5; }},
        {"--drift 0.1:-0.2", [](Options& options) { options.bend.drift = 0.1, options.bend.drift_hz = -0.2; }}}) {
    const std::string expected = recorded(option.set);
    EXPECT_EQ(program(option.arguments), expected) << option.arguments;
    EXPECT_NE(expected, recorded([](Options&) {})) << option.arguments << " disturbs nothing";
  }
}

// When a station samples tells in its answers only: tests/rigsim/reading_faults_test.cpp has what it does.
TEST(CommandLine, TheMomentOfSamplingIsUnderstood) {
  const std::string undisturbed = recorded([](Options&) {});
  for (const char* good : {"--sample answer", "--sample 2:request", "--sample 3:middle"})
    EXPECT_EQ(program(good), undisturbed) << good;
  for (const char* bad : {"--sample never", "--sample y1:request", "--sample 99:middle"})
    EXPECT_EQ(program(bad), "") << bad;
}

TEST(CommandLine, WhatIsWrongWithAnOptionIsRefused) {
  for (const char* bad :
       {"--friction 4", "--friction x:1", "--cubic 9:1", "--hunt 0.1", "--hunt 2:1", "--drift 0.1", "--drift 2:0",
        "--clip y1:1:0", "--converter y1:40:1", "--low-byte y1:256", "--zeros 2", "--repeats y9:0.1", "--stale 1",
        "--freeze 0.1", "--garbage 2", "--glitch y1", "--scale y1:0", "--lag y1:2", "--swap y1:y1"})
    EXPECT_EQ(program(bad), "") << bad;
}

}  // namespace
}  // namespace rigsim
