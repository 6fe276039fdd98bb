#include "core/base/student.hpp"

#include <cmath>
#include <numbers>

namespace dwell {
namespace {

// Density of t with ν degrees of freedom.
double density(double t, double nu) noexcept {
  return std::exp(std::lgamma((nu + 1) / 2) - std::lgamma(nu / 2) - (nu + 1) / 2 * std::log1p(t * t / nu)) /
         std::sqrt(nu * std::numbers::pi);
}

// P(|T| <= t), by Simpson's rule over the angle φ with t = √ν tan φ. There the integrand cos^{ν-1} φ is smooth.
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
  if (!(dof < 60)) {
    // Cornish-Fisher expansion (Abramowitz and Stegun 26.7.5). The first neglected term is below 1e-9 of the result.
    if (!std::isfinite(dof)) return kNormal95;
    const double z = kNormal95, z2 = z * z, i = 1 / dof;
    const double g1 = z * (z2 + 1) / 4;
    const double g2 = z * ((5 * z2 + 16) * z2 + 3) / 96;
    const double g3 = z * (((3 * z2 + 19) * z2 + 17) * z2 - 15) / 384;
    const double g4 = z * ((((79 * z2 + 776) * z2 + 1482) * z2 - 1920) * z2 - 945) / 92160;
    return z + i * (g1 + i * (g2 + i * (g3 + i * g4)));
  }
  const double nu = dof < 1 ? 1 : dof;
  // The probability is concave in t. Newton's method from below therefore never passes the root.
  double t = kNormal95;
  for (int i = 0; i < 100; ++i) {
    const double step = (0.95 - within(t, nu)) / (2 * density(t, nu));
    t += step;
    if (std::abs(step) < 1e-12 * t) break;
  }
  return t;
}

}  // namespace dwell
