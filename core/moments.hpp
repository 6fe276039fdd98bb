// Trigonometric moments: what the harmonic fit needs to know of samples, and nothing more.
//
// With θ = ω (t - t_c) the angle of a sample at t in a block whose centre is t_c, and u = t - t_c (s):
//
//   of the instants,  M_k^j = Σ u^j exp(jkθ),    k = 0 … 2H, j = 0, 1, 2
//   of the readings,  Z_h^j = Σ s u^j exp(jhθ),  h = 0 … H,  j = 0, 1, 2
//
// Every product of two of the regressors 1, sin hθ, cos hθ is a sum of cos and sin of (h ± l)θ, so the (2H+1)²
// information matrix is made of the 4H+1 numbers M^0. The moments with u and u² say how all of it changes with ω and
// t_c:
//
//   exp(jk(θ + φ + δu)) = exp(jkφ) (1 + jkδu - k²δ²u²/2 - …)
//
// so blocks that were taken at slightly different ω can be brought to one ω and added, and the sum's derivative by ω is
// exact. A quarter of a period taken 2 % off leaves an error of (0.016 k)³/6.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dwell::moments {

inline constexpr int kOrders = 3;  // j = 0, 1, 2

// Layout of one set with `count` angles (2H+1 of instants, H+1 of readings): cos then sin for j = 0, then j = 1, j = 2.
[[nodiscard]] constexpr std::size_t size(int count) noexcept { return static_cast<std::size_t>(2 * kOrders * count); }
[[nodiscard]] constexpr std::size_t cosine(int count, int order, int k) noexcept {
  return static_cast<std::size_t>(2 * order * count + k);
}
[[nodiscard]] constexpr std::size_t sine(int count, int order, int k) noexcept {
  return static_cast<std::size_t>((2 * order + 1) * count + k);
}

// exp(jkθ), k = 0 … 2H, and u of one instant.
struct Regressors {
  std::int64_t t_ns = INT64_MIN;
  double u = 0.0;
  std::array<double, 17> c{}, s{};
};

// Fills `out` for the angle theta and time u: one sin, one cos, then the recurrence exp(jkθ) = exp(jθ) exp(j(k-1)θ).
template <int H>
inline void evaluate(double theta, double u, Regressors& out) noexcept {
  const double s1 = std::sin(theta), c1 = std::cos(theta);  // one sincos call after optimization
  out.u = u;
  out.c[0] = 1.0;
  out.s[0] = 0.0;
  out.c[1] = c1;
  out.s[1] = s1;
  const double twice = 2 * c1;
  for (std::size_t k = 2; k <= 2 * H; ++k) {  // Chebyshev: cos kθ = 2 cos θ cos (k-1)θ - cos (k-2)θ, sin alike
    out.c[k] = twice * out.c[k - 1] - out.c[k - 2];
    out.s[k] = twice * out.s[k - 1] - out.s[k - 2];
  }
}

// Adds weight·(1, u, u²)·exp(jkθ), k = 0 … count-1, to a set of `count` angles. weight: 1 for instants, the reading for
// readings, -1 to take an instant back.
template <int count>
inline void add(const Regressors& x, double weight, double* set) noexcept {
  const double w1 = weight * x.u, w2 = w1 * x.u;
  for (std::size_t k = 0; k < count; ++k) {
    set[cosine(count, 0, 0) + k] += weight * x.c[k];
    set[sine(count, 0, 0) + k] += weight * x.s[k];
    set[cosine(count, 1, 0) + k] += w1 * x.c[k];
    set[sine(count, 1, 0) + k] += w1 * x.s[k];
    set[cosine(count, 2, 0) + k] += w2 * x.c[k];
    set[sine(count, 2, 0) + k] += w2 * x.s[k];
  }
}

// Brings a set taken at (ω_b, t_b) to (ω, t_ref) and adds it to `out`: delta = ω - ω_b, phase = ω (t_b - t_ref),
// shift = t_b - t_ref. `in` and `out` must not overlap.
void rebase_add(const double* in, int count, double delta, double phase, double shift, double* out) noexcept;

}  // namespace dwell::moments
