// Lets through one line of log a second: a device or a bus in trouble says so thousands of times a second.
#pragma once

#include <cstdint>

namespace dwell::driver {

class Seldom {
 public:
  // true: a line may be written now, at this instant of CLOCK_MONOTONIC; the next one a second later.
  bool due(std::int64_t now_ns) noexcept {
    if (now_ns < next_ns_) return false;
    next_ns_ = now_ns + kBetween_ns;
    return true;
  }

 private:
  static constexpr std::int64_t kBetween_ns = 1'000'000'000;
  std::int64_t next_ns_ = 0;
};

}  // namespace dwell::driver
