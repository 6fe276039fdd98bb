// Conversion of instants and durations. Stored and compared values are whole nanoseconds (int64); arithmetic uses
// seconds (double).
#pragma once

#include <cmath>
#include <cstdint>

namespace dwell {

inline constexpr double kNsPerS = 1e9;
// A source that has been silent for so long has failed or was restarted, unless it is slow: then some of its periods
// are waited for. Halved, the pauses of a busy bus count as failures. Doubled, operators learn of a failure later.
inline constexpr double kSilent_s = 1.0;

[[nodiscard]] inline std::int64_t to_ns(double s) { return static_cast<std::int64_t>(std::llround(s * 1e9)); }
[[nodiscard]] inline double to_s(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace dwell
