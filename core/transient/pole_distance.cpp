#include "core/transient/pole_distance.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

constexpr double kLeastFall = 1e-4;  // below this the error of the series, 4e-8, would show in 1 - |ρ|²
constexpr double kFewTerms = 1e-2;   // for |z| times the time seen below this the series serves

// ∫ e^{zt} dt over the time seen.
Complex integral(Complex z, double seen_s) {
  const Complex x = z * seen_s;
  return std::abs(x) < kFewTerms ? seen_s * (1.0 + x / 2.0 + x * x / 6.0) : (std::exp(x) - 1.0) / z;
}

// Variance of t, s², weighted by e^{-at} over the time seen.
double variance_of_instants(double a, double seen_s) {
  const double x = a * seen_s;
  const double unit = x < kFewTerms ? (1 - x * x / 20) / 12 : 1 / (x * x) - 1 / (4 * std::pow(std::sinh(x / 2), 2));
  return unit * seen_s * seen_s;
}

}  // namespace

double overstated_distance(Complex seen, Complex other, double seen_s) noexcept {
  if (!(seen.real() < 0) || !(other.real() < 0) || !(seen_s > 0)) return 1.0;
  const double parabola = std::norm(seen - other) * variance_of_instants(-2 * seen.real(), seen_s);
  if (!(parabola > kLeastFall)) return 1.0;
  const double both = std::norm(integral(seen + std::conj(other), seen_s));
  const double own = integral(2 * seen.real(), seen_s).real() * integral(2 * other.real(), seen_s).real();
  return std::max(1.0, parabola / (1 - std::min(both / own, 1 - kLeastFall)));
}

}  // namespace dwell
