// How large the noise of a channel may be, whatever the chain and the table's process are. local_noise() is σ at m = 2
// alone: it misses more of the motion.
//
// A polynomial of degree 2m - 1 through m neighbours on each side foresees the reading between them. What it leaves is
// the noise of all of them, and the part of the motion that it misses. That part falls as m grows, faster the more
// readings a period has. The noise stays, but is told by fewer independent residuals: those of high degree keep the
// highest frequencies alone. With w_i the weights of the residual, at equal steps,
//
//   ρ_k = Σ w_i w_{i+k} / Σ w_i²,   u(σ)/σ = √(Σ ρ_k² / (2 N e)),   k = -2m … 2m,
//
// e the efficiency of the median deviation that gives σ. m goes from 2 to 6 while σ + u(σ) falls, and the last of
// these is taken, so that the choice does not make it too small.
#pragma once

#include <vector>

namespace dwell {

// t: instants, s, rising; value: readings there. σ + u(σ), in the unit of the readings, or more where even the highest
// degree misses motion; NaN below 9 readings. Readings of equal instants, and a few that are far off, do no harm.
// O(readings), at most five times 13²; allocates; thread-safe.
[[nodiscard]] double noise_of_readings(const std::vector<double>& t, const std::vector<double>& value);

}  // namespace dwell
