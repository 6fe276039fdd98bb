// Finds the grid behind a stretch of arrivals: the sampling instants of a device with a constant rate.
//
//   a_j = t_0 + k_j T + d_j,   k_{j+1} > k_j
//
// a_j is the instant at which a reading reached the host, T the device's period, d_j the delay on the way. k_j is the
// reading's number: it jumps where readings were lost. The delay is never negative and jitters by about a period at
// most. A stall makes it much longer now and then; after it readings arrive in a bunch. k, T and t_0 are unknown.
// DeviceClock uses the grid to begin with and follows it from there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/stream/delay_shape.hpp"

namespace dwell {

inline constexpr std::size_t kLongestStretch = 256;  // arrivals that find_grid uses at most
// Evidence for a loss, in nats: it must explain the arrivals exp(3) = 20 times better than none, beside the rate of
// losses. Halved, stalls are taken for losses. Doubled, losses are decided later.
inline constexpr double kLossPrice = 3.0;
inline constexpr double kNominalRange = 5e-4;  // a stated rate is relied on to within this part of it

struct ArrivalGrid {
  double period_ns = 0.0;
  double last_ns = 0.0;  // ns after the first arrival: the last reading's instant on the grid, delays at their mean
  double spread = 0.0;   // mean absolute deviation of the arrivals from the grid, in periods, without stalls
  double lost = 0.0;     // readings lost, per reading that arrived
  DelayShape shape;
};

// arrivals_ns: in order, at most kLongestStretch. nominal_ns: the period, to within kNominalRange; 0: not known (then
// readings lost must be fewer than one in five). Nothing: no grid explains the arrivals. No allocation; about 100 µs
// for 256 arrivals.
[[nodiscard]] std::optional<ArrivalGrid> find_grid(std::span<const std::int64_t> arrivals_ns,
                                                   double nominal_ns) noexcept;

}  // namespace dwell
