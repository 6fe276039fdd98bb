// Refines the drive's frequency from all channels.
#pragma once

#include <cmath>

#include "core/drive/sync_reference.hpp"
#include "core/fit/totals.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct Refined {
  double omega = 0.0;   // rad/s
  double u = 0.0;       // its standard uncertainty, rad/s: from the residuals and what is stated
  bool reached = true;  // no: it lies further from the sums' own ω than these can be turned; sum the blocks anew at it
  double data_omega = 0.0;   // what the data alone say, rad/s …
  double u_data = INFINITY;  // … and its standard uncertainty; infinity: nothing
};

// Gauss-Newton on ω, all channels of motion and force weighted by their own residuals; within the rig's search range; a
// fixed reference is a prior (core/fit/frequency_prior.hpp). `sums`: the data, at an ω near the solution. Leaves in
// `out` the sums at the refined ω about the centroid of `reference_channel`'s samples, where phase and frequency are
// uncorrelated. Seven steps at most, each O(channels · H³), no allocation. Thread-safe if `out` is the caller's own.
[[nodiscard]] Refined refine(const Rig& rig, const Totals& sums, int reference_channel, Totals& out) noexcept;

// The same where pulses give the frequency: nothing is fitted, and `out` is about the instant of phase zero next to the
// centroid; half a period away from it phase and frequency are as good as uncorrelated.
[[nodiscard]] Refined refine(const PulseLine& pulses, const Totals& sums, int reference_channel, Totals& out) noexcept;

// ω within the range that the rig file allows to be searched, and near what it states.
[[nodiscard]] double within_search(const Rig& rig, double omega) noexcept;

}  // namespace dwell
