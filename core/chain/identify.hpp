// Identifies the elements of a chain from the phasors of one steady frequency: exact, O(n), no linear solve.
//
// In the sum of the equations of masses k … n all forces between these masses cancel (Konchak and Nazarenko 2016, eqs.
// (1), (14), (24), in phasor form; the closed forms (5)-(35) of the paper follow from this sum):
//
//   free:     Z_k = ω² Σ_{i=k..n} m_i Y_i / d_k
//   clamped:  Z_k = (ω² Σ_{i=k..n} m_i Y_i - F) / d_k,  k = 1 … n;   Z_{n+1} = F / Y_n
//
//   Z_k = c_k + jω r_k is the dynamic stiffness and d_k = Y_k - Y_{k-1} the deformation of element k. F is the force of
//   element n+1 on the ground, positive when mass n is displaced in +y. y(t) = Im(Y exp(jωt)).
#pragma once

#include <complex>
#include <span>

#include "core/base/complex.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Stiffness and damping of a dynamic stiffness: c = Re Z, r = Im Z / ω.
[[nodiscard]] inline double stiffness(Complex Z) noexcept { return Z.real(); }
[[nodiscard]] inline double damping(Complex Z, double omega) noexcept { return Z.imag() / omega; }

// masses: m_1 … m_n (kg, kg·m²), n >= 0, n >= 1 if free. omega: rad/s, > 0. Y: Y_0 … Y_n (m, rad). d: d_1 … d_n, the
// deformations (differences of Y, or what transducers across the elements read). F: N (N·m), ignored if free.
// Z: receives Z_1 … (n if free, n + 1 if clamped), N/m (N·m/rad); not finite for an element that does not deform.
// Real-time safe, thread-safe, O(n).
void identify(Boundary boundary, std::span<const double> masses, double omega, std::span<const Complex> Y,
              std::span<const Complex> d, Complex F, std::span<Complex> Z) noexcept;

}  // namespace dwell
