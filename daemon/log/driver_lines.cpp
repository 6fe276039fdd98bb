#include "daemon/log/driver_lines.hpp"

namespace dwell {
namespace {

Level level_of(dwell_level level) {
  switch (level) {
    case DWELL_DEBUG:
      return Level::debug;
    case DWELL_INFO:
      return Level::info;
    case DWELL_WARNING:
      return Level::warning;
    case DWELL_ERROR:
      return Level::error;
  }
  return Level::error;
}

}  // namespace

void DriverLines::line(dwell_level level, const char* message, std::int64_t now_ns) {
  if (now_ns - second_ns_ >= 1'000'000'000) {
    if (kept_back_ > 0)
      log_.warning("device " + device_ + ": " + std::to_string(kept_back_) + " lines of its driver left out");
    second_ns_ = now_ns;
    lines_ = kept_back_ = 0;
  }
  if (++lines_ > kLinesPerSecond) {
    ++kept_back_;
    return;
  }
  log_.write(level_of(level), "device " + device_ + ": " + message, {{"DWELL_DEVICE", device_}});
}

}  // namespace dwell
