// Instants in UTC as text. Thread-safe.
#pragma once

#include <cstdint>
#include <string>

namespace dwell::record {

// CLOCK_MONOTONIC_RAW and UTC, read together.
struct ClockPair {
  std::int64_t raw_ns = 0;
  std::int64_t utc_ns = 0;
};

// "2026-11-23T03:12:17.250000Z"
[[nodiscard]] std::string iso_utc(std::int64_t utc_ns);
// "20261123T031217Z", for file names
[[nodiscard]] std::string compact_utc(std::int64_t utc_ns);
// Of an instant of the raw clock.
[[nodiscard]] inline std::int64_t utc_of(const ClockPair& now, std::int64_t raw_ns) noexcept {
  return now.utc_ns - (now.raw_ns - raw_ns);
}

}  // namespace dwell::record
