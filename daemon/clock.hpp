// The clocks of the service: instants in CLOCK_MONOTONIC_RAW, which nothing steps or slews. Thread-safe, real-time
// safe.
#pragma once

#include <cstdint>
#include <ctime>

namespace dwell {

inline std::int64_t read_clock_ns(clockid_t clock) noexcept {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// The instants of samples, ticks and thread turns.
inline std::int64_t raw_now_ns() noexcept { return read_clock_ns(CLOCK_MONOTONIC_RAW); }

// UTC, to be recorded and shown, never computed with.
inline std::int64_t utc_now_ns() noexcept { return read_clock_ns(CLOCK_REALTIME); }

}  // namespace dwell
