#include "core/student.hpp"

#include <cmath>
#include <numbers>

namespace dwell {
namespace {

constexpr double kNormal95 = 1.959963984540054;

// Density of t with ν degrees of freedom.
double density(double t, double nu) noexcept {
  return std::exp(std::lgamma((nu + 1) / 2) - std::lgamma(nu / 2) - (nu + 1) / 2 * std::log1p(t * t / nu)) /
         std::sqrt(nu * std::numbers::pi);
}

// P(|T| <= t): integral of the density by Simpson's rule in the angle t = √ν tan φ, where it is ∝ cos^{ν-1} φ, smooth.
double within(double t, double nu) noexcept {
  constexpr int kSteps = 400;
  const double end = std::atan(t / std::sqrt(nu));
  double sum = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double phi = end * i / kSteps;
    const double weight = i == 0 || i == kSteps ? 1 : (i % 2 ? 4 : 2);
    sum += weight * std::pow(std::cos(phi), nu - 1);
  }
  return 2 * density(0.0, nu) * std::sqrt(nu) * sum * end / (3 * kSteps);
}

}  // namespace

double student_t95(double dof) noexcept {
  if (!(dof < 1e6)) {
    // Cornish-Fisher, exact to 1e-12 this far out.
    const double z = kNormal95;
    return std::isfinite(dof) ? z + (z * z * z + z) / (4 * dof) : z;
  }
  const double nu = dof < 1 ? 1 : dof;
  double t = nu < 1.5 ? 12.7 : kNormal95 * (1 + 1.3 / nu);
  for (int i = 0; i < 50; ++i) {
    const double step = (within(t, nu) - 0.95) / (2 * density(t, nu));
    t -= step;
    if (std::abs(step) < 1e-12 * t) break;
  }
  return t;
}

}  // namespace dwell
