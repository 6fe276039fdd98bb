// Doubling pauses between attempts, from 0.1 s to 5 s.
#pragma once

#include <algorithm>
#include <cstdint>

namespace dwell::socketcan {

class Backoff {
 public:
  [[nodiscard]] std::int64_t next_ns() noexcept {
    const std::int64_t wait_ns = next_ns_;
    next_ns_ = std::min(2 * next_ns_, kLongest_ns);
    return wait_ns;
  }
  void reset() noexcept { next_ns_ = kShortest_ns; }

 private:
  static constexpr std::int64_t kShortest_ns = 100'000'000, kLongest_ns = 5'000'000'000;
  std::int64_t next_ns_ = kShortest_ns;
};

}  // namespace dwell::socketcan
