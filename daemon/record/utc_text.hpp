// Instants in UTC as text. Thread-safe.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// CLOCK_MONOTONIC_RAW and UTC, read together.
struct ClockPair {
  std::int64_t raw_ns = 0;
  std::int64_t utc_ns = 0;
};

// "2026-11-23T03:12:17.250000Z", rounded down to the microsecond. utc_ns: since 1970; years 1678 to 2262.
[[nodiscard]] std::string iso_utc(std::int64_t utc_ns);
// The text of iso_utc() shortened to the second, for file names: "20261123T031217Z".
[[nodiscard]] std::string compact_utc(const std::string& iso);
// Parses the form of iso_utc(), with any number of decimals or none; ns since 1970. Does not check the ranges of month,
// day and time. At most kMostUtc_ns from 1970 (instants.hpp). Fails with what was expected.
[[nodiscard]] Result<std::int64_t> parse_utc(const std::string& iso);
// UTC at an instant of the raw clock.
[[nodiscard]] inline std::int64_t utc_of(const ClockPair& now, std::int64_t raw_ns) noexcept {
  return now.utc_ns - (now.raw_ns - raw_ns);
}

}  // namespace dwell::record
