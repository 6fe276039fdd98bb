#include "core/moments.hpp"

namespace dwell::moments {

void rebase_add(const double* in, int count, double delta, double phase, double shift, double* out) noexcept {
  const double turn_c = std::cos(phase), turn_s = std::sin(phase);
  double c = 1.0, s = 0.0;  // exp(jk·phase)
  for (int k = 0; k < count; ++k) {
    const double a = k * delta, b = 0.5 * a * a;
    const double c0 = in[cosine(count, 0, k)], s0 = in[sine(count, 0, k)];
    const double c1 = in[cosine(count, 1, k)], s1 = in[sine(count, 1, k)];
    const double c2 = in[cosine(count, 2, k)], s2 = in[sine(count, 2, k)];
    // exp(jkδu) to second order in the moment that is known, first in u·, zeroth in u²·.
    const double x0 = c0 - a * s1 - b * c2, y0 = s0 + a * c1 - b * s2;
    const double x1 = c1 - a * s2, y1 = s1 + a * c2;
    const double p0 = c * x0 - s * y0, q0 = s * x0 + c * y0;
    const double p1 = c * x1 - s * y1, q1 = s * x1 + c * y1;
    const double p2 = c * c2 - s * s2, q2 = s * c2 + c * s2;
    out[cosine(count, 0, k)] += p0;
    out[sine(count, 0, k)] += q0;
    out[cosine(count, 1, k)] += p1 + shift * p0;
    out[sine(count, 1, k)] += q1 + shift * q0;
    out[cosine(count, 2, k)] += p2 + shift * (2 * p1 + shift * p0);
    out[sine(count, 2, k)] += q2 + shift * (2 * q1 + shift * q0);
    const double next = c * turn_c - s * turn_s;
    s = c * turn_s + s * turn_c;
    c = next;
  }
}

}  // namespace dwell::moments
