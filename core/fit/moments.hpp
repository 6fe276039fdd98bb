// Trigonometric moments: the sums over samples that the harmonic fit needs, and nothing more.
//
// With θ = ω (t - t_c) the angle of a sample at t about a centre t_c, and u = t - t_c (s):
//
//   of the instants,  M_k^j = Σ u^j exp(jkθ),    k = 0 … 2H, j = 0, 1;   and Σ u²
//   of the readings,  Z_h^j = Σ s u^j exp(jhθ),  h = 0 … H,  j = 0, 1;   and Σ s²
//
// A product of two regressors 1, sin hθ, cos hθ is a sum of cos and sin of (h ± l)θ. So the 4H+1 numbers M^0 make the
// (2H+1)² information matrix. The moments with u tell how the sums change with ω and t_c:
//
//   exp(jk(θ + φ + δu)) = exp(jkφ) (1 + jkδu - k²δ²u²/2 - …)
//
// Here φ is a shift of t_c as an angle, δ a change of ω, and u² is taken at its mean. So sums at slightly different ω
// can be turned to one ω and added, and the fit's derivative by ω is exact. The relative error of turning is below
// (kδu)²/6 for a quarter of a period, and below (kδu)³/6 for a hundred periods and more; core/drive/refine.cpp says
// what it is between.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/packed.hpp"

namespace dwell::moments {

// Layout of a set of `count` angles (2H+1 of instants, H+1 of readings): cos, sin for j = 0; cos, sin for j = 1; the
// sum of squares. The four rows are padded to an even number, since two doubles fill one register.
[[nodiscard]] constexpr std::size_t stride(int count) noexcept {
  return (static_cast<std::size_t>(count) + 1) & ~std::size_t{1};
}
[[nodiscard]] constexpr std::size_t size(int count) noexcept { return 4 * stride(count) + 2; }
[[nodiscard]] constexpr std::size_t cosine(int count, int order, int k) noexcept {
  return 2 * static_cast<std::size_t>(order) * stride(count) + static_cast<std::size_t>(k);
}
[[nodiscard]] constexpr std::size_t sine(int count, int order, int k) noexcept {
  return cosine(count, order, k) + stride(count);
}
[[nodiscard]] constexpr std::size_t squares(int count) noexcept { return 4 * stride(count); }

// exp(jkθ), k = 0 … 2H (zero beyond), and u of one instant.
struct Regressors {
  std::int64_t t_ns = INT64_MIN;
  double u = 0.0;
  alignas(16) std::array<double, 18> c{}, s{};
};

// sin x and cos x for |x| < 1 by Taylor series. A quarter of a period about its centre needs |x| <= π/4 only, where the
// next terms are below 5e-17. Costs a fraction of libm and gives the same bits with any libm.
inline void sin_cos(double x, double& sine_x, double& cosine_x) noexcept {
  constexpr auto inverse_factorial = [](int n) {
    double product = 1.0;
    for (int i = 2; i <= n; ++i) product *= i;
    return 1.0 / product;
  };
  constexpr double f3 = inverse_factorial(3), f4 = inverse_factorial(4), f5 = inverse_factorial(5),
                   f6 = inverse_factorial(6), f7 = inverse_factorial(7), f8 = inverse_factorial(8),
                   f9 = inverse_factorial(9), f10 = inverse_factorial(10), f11 = inverse_factorial(11),
                   f12 = inverse_factorial(12), f13 = inverse_factorial(13), f14 = inverse_factorial(14),
                   f15 = inverse_factorial(15), f16 = inverse_factorial(16);
  const double z = x * x, z2 = z * z, z4 = z2 * z2;
  const double odd = (f5 * z - f3) + z2 * (f9 * z - f7) + z4 * ((f13 * z - f11) - f15 * z2);
  const double even = (f4 - f6 * z) + z2 * (f8 - f10 * z) + z4 * ((f12 - f14 * z) + f16 * z2);
  sine_x = x + x * z * odd;
  cosine_x = 1.0 - (0.5 * z - z2 * even);
}

// Fills `out` for the angle theta, |theta| < 1 rad, and the time u, s. exp(jkθ) follows from the Chebyshev recurrence
// cos kθ = 2 cos θ cos (k-1)θ - cos (k-2)θ, and the same for sin.
template <int H>
inline void evaluate(double theta, double u, Regressors& out) noexcept {
  out.u = u;
  double sine = 0.0, cosine = 0.0;
  sin_cos(theta, sine, cosine);
  const double twice = 2 * cosine;
  double c = 1.0, s = 0.0, next_c = cosine, next_s = sine;  // of k and k + 1
  for (std::size_t k = 0; k < 2 * H; k += 2) {
    store_two(&out.c[k], c, next_c);
    store_two(&out.s[k], s, next_s);
    c = twice * next_c - c;
    s = twice * next_s - s;
    next_c = twice * c - next_c;
    next_s = twice * s - next_s;
  }
  store_two(&out.c[2 * H], c, 0.0);
  store_two(&out.s[2 * H], s, 0.0);
}

// Adds weight·(1, u)·exp(jkθ), k = 0 … count-1, and `square` to a set. For instants: weight = 1 (-1 removes one),
// square = weight·u². For readings: weight = s, square = s².
template <int count>
inline void add(const Regressors& x, double weight, double square, double* __restrict set) noexcept {
  constexpr std::size_t kStride = stride(count);
  const double slope = weight * x.u;
  for (std::size_t k = 0; k < kStride; ++k) {
    set[k] += weight * x.c[k];
    set[kStride + k] += weight * x.s[k];
    set[2 * kStride + k] += slope * x.c[k];
    set[3 * kStride + k] += slope * x.s[k];
  }
  set[4 * kStride] += square;
}

// The change of a set from (ω_b, t_b) to (ω, t_ref).
struct Turn {
  // faster: ω - ω_b, rad/s; phase: ω (t_b - t_ref), rad; later: t_b - t_ref, s; count: most angles that a set has.
  Turn(double faster, double phase, double later, int count) noexcept;
  double delta, shift;
  std::array<double, 18> c{}, s{};  // exp(jk·phase); zero beyond `count`
};

// Turns `in` and adds it to `out`; they must not overlap. mean_square_u: mean of u² over the instants of the readings,
// from the set of these instants.
void add_instants(const double* in, int count, const Turn& turn, double* out) noexcept;
void add_readings(const double* in, int count, const Turn& turn, double mean_square_u, double* out) noexcept;
[[nodiscard]] inline double mean_square_u(const double* instants, int count) noexcept {
  return instants[0] > 0 ? instants[squares(count)] / instants[0] : 0.0;
}

}  // namespace dwell::moments
