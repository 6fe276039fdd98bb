// The forward model in the frequency domain: steady response and natural values of a chain with known coefficients.
// core/model/driven_chain.hpp is the same in the time domain.
//
// Phasors as in docs/method.md, Symbols: y = Im(Y exp(jωt)). With s = jω the equations of motion (1), (14), (24) are
// (s² M + s C + K) Y = (c_1 + s r_1) Y_0 e_1, a complex symmetric tridiagonal system.
// Every function needs a chain without a fault(). All are pure, thread-safe, and allocate.
#pragma once

#include <complex>
#include <vector>

#include "core/model/chain.hpp"

namespace dwell {

using Phasor = std::complex<double>;

struct SteadyResponse {
  std::vector<Phasor> Y;  // Y_0 (as given) … Y_n, m (rad)
  Phasor F;               // force of element n+1 on the ground, N (N·m), + when mass n is displaced in +; free: 0
};

// Steady response to a table that moves with phasor Y0 (m, rad) at omega (rad/s, ≥ 0; 0 is the static case). Not finite
// for an undamped chain driven exactly at a natural frequency. O(n), partial pivoting.
[[nodiscard]] SteadyResponse steady_response(const Chain& chain, double omega, Phasor Y0);

// Solves (s² M + s C + K) x = b in place; b has n entries. Not finite if singular. O(n), partial pivoting.
void solve_dynamic(const Chain& chain, Phasor s, std::vector<Phasor>& b);

// The 2n natural values λ (poles) of the chain with the table held, 1/s: every free motion is a sum of exp(λt). An
// underdamped mode has a conjugate pair, Im λ its damped natural frequency. Empty for n = 0, and if the computation
// does not converge. O(n³).
[[nodiscard]] std::vector<std::complex<double>> natural_values(const Chain& chain);

// Decay rate -max Re λ of the slowest mode, 1/s. Zero or negative: that mode does not decay. +∞ for n = 0; NaN if
// natural_values() fails. O(n³).
[[nodiscard]] double slowest_decay_rate(const Chain& chain);

}  // namespace dwell
