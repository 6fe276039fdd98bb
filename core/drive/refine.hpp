// Refines the drive's frequency from the data of all channels, or takes it from the sync pulses.
#pragma once

#include <cmath>

#include "core/drive/sync_reference.hpp"
#include "core/fit/totals.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// An iteration on ω ends once its step is below this part of ω's standard uncertainty.
inline constexpr double kNegligibleStep = 1e-2;
// Steps of an iteration on ω, at most: from half a cell away, each step about squares the error.
inline constexpr int kMostSteps = 10;

struct Refined {
  double omega = 0.0;      // rad/s
  double u = 0.0;          // its standard uncertainty, rad/s, by residuals and prior; NaN: nothing tells ω
  bool sums_valid = true;  // false: ω is farther from the sums' own than they can be turned; sum the blocks anew at ω
  double data_omega = 0.0;   // ω by the data alone, rad/s
  double u_data = INFINITY;  // its standard uncertainty; infinity: the data do not tell ω
};

// Gauss-Newton on ω within the rig's search range. Each channel of motion or force is weighted by its own residuals. A
// fixed reference is a prior (core/fit/frequency_prior.hpp). `sums`: the data, at an ω near the solution and about
// the middle of the data. `out` gets the sums at the refined ω about the centroid of `reference_channel`, where phase
// and frequency are uncorrelated. Seven steps at most, each O(channels · H³), no allocation. Thread-safe if `out` is
// the caller's own.
[[nodiscard]] Refined refine(const Rig& rig, const Totals& sums, int reference_channel, Totals& out) noexcept;

// The same if pulses give the frequency: nothing is fitted. `out` is about the instant of phase zero nearest to the
// centroid. That is half a period away at most, so phase and frequency are practically uncorrelated.
[[nodiscard]] Refined refine(const PulseLine& pulses, const Totals& sums, int reference_channel, Totals& out) noexcept;

// ω, rad/s, limited to the search range and to what does not contradict the rig file's statement.
[[nodiscard]] double within_search(const Rig& rig, double omega) noexcept;

}  // namespace dwell
