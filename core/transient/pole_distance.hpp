// How far apart the samples see two poles (docs/method.md, Cross-check).
#pragma once

#include "core/base/complex.hpp"

namespace dwell {

// Near the pole that was fitted the log-likelihood falls as a parabola, which the covariance describes. Far from it it
// falls less: it leaves at most all of an oscillation unexplained. Returns the parabola over the true fall at `other`,
// at least 1. Exact for one oscillation of free amplitude in white noise, seen from its begin for seen_s:
//
//   |λ - λ'|² Var(t) / (1 - |ρ|²) ,  ρ: correlation of e^{λt} and e^{λ't}; t weighted by |e^{λt}|²
//
// seen: the pole fitted, rad/s, Re < 0; other: rad/s. 1 where other does not decay or seen_s is not positive.
// Thread-safe, real-time safe, O(1).
[[nodiscard]] double overstated_distance(Complex seen, Complex other, double seen_s) noexcept;

}  // namespace dwell
