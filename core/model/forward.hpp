// The forward model in the frequency domain: what a chain of known coefficients does under a steady drive, and how fast
// it forgets. The time domain is core/model/driven_chain.hpp.
//
// Phasors as in docs/method.md, Symbols: y = Im(Y exp(jωt)). With s = jω the equations of motion (1), (14), (24) are
// (s² M + s C + K) Y = (c_1 + s r_1) Y_0 e_1, a complex symmetric tridiagonal system.
// Every function needs a chain without a fault(); all are pure and may be called from any thread.
#pragma once

#include <complex>
#include <vector>

#include "core/model/chain.hpp"

namespace dwell {

using Phasor = std::complex<double>;

struct SteadyResponse {
  std::vector<Phasor> Y;  // Y_0 (as given) … Y_n, m (rad)
  Phasor F;  // the force of element n+1 on the ground, N (N·m), positive when mass n is displaced in +y; free: 0
};

// The steady response to a table moving with Y0 at ω (rad/s, ≥ 0; 0 is the static case). Not finite where the chain has
// no steady response (undamped, driven exactly at a natural frequency). O(n), partial pivoting.
[[nodiscard]] SteadyResponse steady_response(const Chain& chain, double omega, Phasor Y0);

// Solves (s² M + s C + K) x = b for one b of n entries, in place. O(n), partial pivoting; not finite where singular.
void solve_dynamic(const Chain& chain, Phasor s, std::vector<Phasor>& b);

// The 2n natural values λ of the chain with the table held: every free motion is a sum of exp(λt). 1/s. Underdamped
// modes come as conjugate pairs with Im λ the damped natural frequency. O(n³), allocates. Empty for n = 0, and where
// the computation did not converge.
[[nodiscard]] std::vector<std::complex<double>> natural_values(const Chain& chain);

// -max Re λ, 1/s: the rate at which the longest-lived transient decays. Zero or negative: it never does. +∞ for n = 0;
// NaN where natural_values failed. O(n³).
[[nodiscard]] double slowest_decay_rate(const Chain& chain);

}  // namespace dwell
