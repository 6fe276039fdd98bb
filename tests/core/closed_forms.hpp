// The paper's closed forms, as corrected and as printed; they live here and nowhere else. The code computes the phasor
// form (core/chain/identify.hpp). Equation numbers: Konchak and Nazarenko, 2016.
#pragma once

#include <cmath>
#include <vector>

namespace dwell {

struct ClosedFormInput {
  bool clamped;
  std::vector<double> m;  // m_1 … m_n at m[0] …
  double omega;
  std::vector<double> A, alpha;  // of y_0 … y_n
  double f, beta;                // force on the ground
};

struct Pair {
  double c, r;
};

// D_k = A_k² + A_{k-1}² - 2 A_k A_{k-1} cos(α_k - α_{k-1})
inline double deformation_squared(const ClosedFormInput& in, std::size_t k) {
  const auto& A = in.A;
  return A[k] * A[k] + A[k - 1] * A[k - 1] - 2 * A[k] * A[k - 1] * std::cos(in.alpha[k] - in.alpha[k - 1]);
}

struct ClosedFormSigns {
  double inertia_in_r = 1.0;        // the sign before the inertial sum of r_k
  double force = 1.0;               // +1: f is the force on the ground
  bool repeat_last_cosine = false;  // (19): cos(α_k-α_{k-1}) twice in the term of mass n of c_k, 1 < k < n
};

inline std::vector<Pair> closed_forms(const ClosedFormInput& in, const ClosedFormSigns& signs) {
  const std::size_t n = in.m.size();
  const auto& A = in.A;
  const auto& a = in.alpha;
  const double w = in.omega, f = in.clamped ? in.f * signs.force : 0.0, beta = in.beta;
  std::vector<Pair> out;
  for (std::size_t k = 1; k <= n; ++k) {
    const double D = deformation_squared(in, k);
    double c = 0, r = 0;
    for (std::size_t i = k; i <= n; ++i) {
      const bool repeated = signs.repeat_last_cosine && i == n && k > 1 && k < n;
      const double to_k = repeated ? std::cos(a[k] - a[k - 1]) : std::cos(a[i] - a[k]);
      const double to_before = repeated ? std::cos(a[k] - a[k - 1]) : std::cos(a[i] - a[k - 1]);
      c += in.m[i - 1] * A[i] * (A[k] * to_k - A[k - 1] * to_before);
      r += in.m[i - 1] * A[i] * (A[k] * std::sin(a[i] - a[k]) - A[k - 1] * std::sin(a[i] - a[k - 1]));
    }
    out.push_back(
        {(w * w * c - f * (A[k] * std::cos(a[k] - beta) - A[k - 1] * std::cos(a[k - 1] - beta))) / D,
         (signs.inertia_in_r * w * w * r + f * (A[k] * std::sin(a[k] - beta) - A[k - 1] * std::sin(a[k - 1] - beta))) /
             (w * D)});
  }
  if (in.clamped) out.push_back({in.f * std::cos(a[n] - beta) / A[n], -in.f * std::sin(a[n] - beta) / (w * A[n])});
  return out;
}

inline std::vector<Pair> corrected_closed_forms(const ClosedFormInput& in) { return closed_forms(in, {}); }

// (18)-(20): a leading minus on the inertial sum of every r; in (19) one cosine twice.
inline std::vector<Pair> printed_free_18_to_20(const ClosedFormInput& in) {
  return closed_forms(in, {.inertia_in_r = -1.0, .force = 1.0, .repeat_last_cosine = true});
}

// (32)-(35) hold for the force on the mass; with f on the ground, as (31) has it, every f term has the wrong sign.
inline std::vector<Pair> printed_clamped_32_to_35(const ClosedFormInput& in) {
  return closed_forms(in, {.inertia_in_r = 1.0, .force = -1.0, .repeat_last_cosine = false});
}

}  // namespace dwell
