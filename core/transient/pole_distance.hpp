// How far apart the samples see two poles (docs/method.md, Cross-check).
#pragma once

#include "core/base/complex.hpp"

namespace dwell {

// A pole with its covariance stands for the parabola that touches the log-likelihood at the pole fitted. Farther away
// the parabola is too steep: two decaying oscillations are at most orthogonal. Returns by what factor the parabola
// overstates the distance of `other` from `seen`, at least 1. It is exact for one oscillation of free amplitude in
// white noise, seen from its begin for seen_s:
//
//   |λ - λ'|² Var(t) / (1 - |ρ|²) ,  ρ: correlation of e^{λt} and e^{λ't},  Var(t): of the instants, weighted by
//   |e^{λt}|²
//
// seen: the pole fitted, rad/s, Re < 0; other: rad/s. 1 where other does not decay or seen_s is not positive.
// Thread-safe, real-time safe, O(1).
[[nodiscard]] double overstated_distance(Complex seen, Complex other, double seen_s) noexcept;

}  // namespace dwell
