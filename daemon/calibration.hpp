// Until when a channel's calibration is due, and whether it is overdue, by the date in the rig file. Pure; allocates.
#pragma once

#include <cstdint>
#include <optional>

#include "core/rig/rig.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell {

// Whether the calibration is overdue. The date is the day on which it is due, in UTC: the last one on which it holds.
// utc_ns: UTC now, ns since 1970, of a synchronized clock; 0: there is none. None: the rig file states no date, or the
// day of today is not known.
[[nodiscard]] inline std::optional<bool> calibration_overdue(const Channel& channel, std::int64_t utc_ns) {
  if (channel.calibration.due.empty() || utc_ns == 0) return std::nullopt;
  return channel.calibration.due < record::iso_utc(utc_ns).substr(0, 10);  // ISO dates sort as text
}

// When the calibration becomes overdue: the end of that day, UTC, s since 1970. None: the rig file states no date.
[[nodiscard]] inline std::optional<double> calibration_ends_s(const Channel& channel) {
  if (channel.calibration.due.empty()) return std::nullopt;
  const auto begin_ns = record::parse_utc(channel.calibration.due + "T00:00:00Z");
  constexpr double kDay_s = 86400.0;
  if (!begin_ns) return std::nullopt;
  return 1e-9 * static_cast<double>(*begin_ns) + kDay_s;
}

}  // namespace dwell
