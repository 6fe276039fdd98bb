// Conversion of instants and durations. Stored and compared values are whole nanoseconds (int64); arithmetic uses
// seconds (double).
#pragma once

#include <cmath>
#include <cstdint>

namespace dwell {

inline constexpr double kNsPerS = 1e9;

[[nodiscard]] inline std::int64_t to_ns(double s) { return static_cast<std::int64_t>(std::llround(s * 1e9)); }
[[nodiscard]] inline double to_s(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace dwell
