// What a driver says in words, on its way into the log: under its device's name, and at most so many lines a second.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "daemon/log/log.hpp"
#include "drivers/dwell_driver.h"

namespace dwell {

// Bound to the driver's thread. The log must outlive it.
class DriverLines {
 public:
  // A driver that repeats itself every turn must not push the others' lines out of the log: its 40 MB hold six hours of
  // one that does, at 100 bytes a line. Doubled, they hold three; halved, what a driver says at its start may be cut.
  static constexpr int kLinesPerSecond = 20;

  DriverLines(std::string device, Log& log) : device_(std::move(device)), log_(log) {}

  // now_ns: CLOCK_MONOTONIC_RAW.
  void line(dwell_level level, const char* message, std::int64_t now_ns);

 private:
  std::string device_;
  Log& log_;
  std::int64_t second_ns_ = 0;  // when the second began in which the lines are counted
  int lines_ = 0;
  int kept_back_ = 0;
};

}  // namespace dwell
