// Finds the grid behind a stretch of arrivals: a device that samples at a constant rate, seen only through the instants
// at which its readings reached the host.
//
//   a_j = t_0 + k_j T + d_j,   k_{j+1} > k_j
//
// a_j the arrival, k_j the number of the reading (k jumps where readings were lost), T the device's period, d_j the
// delay on the way: never negative, jittering by about a period at most, now and then much longer (a stall, after which
// readings arrive in a bunch). All of k, T and t_0 are unknown. Used once, to begin with: DeviceClock follows from
// there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/stream/delay_shape.hpp"

namespace dwell {

inline constexpr std::size_t kLongestStretch = 256;  // arrivals that find_grid looks at
inline constexpr double kNominalRange = 5e-4;        // a stated rate is within that of the true one

struct ArrivalGrid {
  double period_ns = 0.0;
  double last_ns = 0.0;  // the last reading's instant on the grid, after the first arrival; delays at their mean
  double spread = 0.0;   // mean absolute deviation of the arrivals from the grid, in periods, stalls left out
  double lost = 0.0;     // readings lost, relative to those arrived
  DelayShape shape;
};

// arrivals: in order, at most kLongestStretch. nominal_ns: the period to within 2 %, 0: not known (then readings lost
// must be fewer than one in five). Nothing: no grid explains the arrivals. No allocation; about 100 µs for 256
// arrivals.
[[nodiscard]] std::optional<ArrivalGrid> find_grid(std::span<const std::int64_t> arrivals_ns,
                                                   double nominal_ns) noexcept;

}  // namespace dwell
