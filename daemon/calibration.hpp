// Whether a channel's calibration has expired, by its date in the rig file. Pure; allocates.
#pragma once

#include <cstdint>
#include <optional>

#include "core/rig/rig.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell {

// The date is the last day on which it holds, in UTC. utc_ns: of a clock that is synchronized; 0: there is none. None:
// the rig file states no date, or what day it is now is not known.
[[nodiscard]] inline std::optional<bool> calibration_overdue(const Channel& channel, std::int64_t utc_ns) {
  if (channel.calibration_due.empty() || utc_ns == 0) return std::nullopt;
  return channel.calibration_due < record::iso_utc(utc_ns).substr(0, 10);  // ISO dates sort as text
}

// When it stops to hold: the end of that day, s since 1970; none: the rig file states no date.
[[nodiscard]] inline std::optional<double> calibration_ends_s(const Channel& channel) {
  if (channel.calibration_due.empty()) return std::nullopt;
  const auto begin_ns = record::parse_utc(channel.calibration_due + "T00:00:00Z");
  constexpr double kDay_s = 86400.0;
  if (!begin_ns) return std::nullopt;
  return 1e-9 * static_cast<double>(*begin_ns) + kDay_s;
}

}  // namespace dwell
