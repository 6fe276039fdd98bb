// Doubling pauses between attempts, from 0.1 s to a longest one.
#pragma once

#include <algorithm>
#include <cstdint>

namespace dwell::driver {

class Backoff {
 public:
  static constexpr std::int64_t kShortest_ns = 100'000'000, kLongest_ns = 5'000'000'000;

  explicit Backoff(std::int64_t longest_ns = kLongest_ns) noexcept : longest_ns_(longest_ns) {}
  [[nodiscard]] std::int64_t next_ns() noexcept {
    const std::int64_t wait_ns = next_ns_;
    next_ns_ = std::min(2 * next_ns_, longest_ns_);
    return wait_ns;
  }
  void reset() noexcept { next_ns_ = kShortest_ns; }

 private:
  std::int64_t longest_ns_;
  std::int64_t next_ns_ = kShortest_ns;
};

}  // namespace dwell::driver
