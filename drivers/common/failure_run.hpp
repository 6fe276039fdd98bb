// Failures in a row: one is an incident, which is counted; from the third on, or after a second of them, they are a
// state, which is told. Fewer would call a channel stale for every disturbance, more would hide a dead one.
#pragma once

#include <algorithm>
#include <cstdint>

namespace dwell::driver {

class FailureRun {
 public:
  // One more, at an instant of CLOCK_MONOTONIC. true: they are a state by now.
  bool add(std::int64_t now_ns) noexcept {
    if (failures_ == 0) since_ns_ = now_ns;
    failures_ = std::min(failures_ + 1, kToState);
    return failures_ == kToState || now_ns - since_ns_ >= kToState_ns;
  }
  // Something went well.
  void end() noexcept { failures_ = 0; }

 private:
  static constexpr int kToState = 3;
  static constexpr std::int64_t kToState_ns = 1'000'000'000;
  int failures_ = 0;
  std::int64_t since_ns_ = 0;
};

}  // namespace dwell::driver
