#include "core/chain/identify.hpp"

#include <cassert>

namespace dwell {

void identify(Boundary boundary, std::span<const double> masses, double omega, std::span<const Complex> Y,
              std::span<const Complex> d, Complex F, std::span<Complex> Z) noexcept {
  const std::size_t n = masses.size();
  const bool clamped = boundary == Boundary::clamped;
  assert(Y.size() == n + 1 && d.size() == n && Z.size() == n + (clamped ? 1 : 0));
  if (clamped) Z[n] = F / Y[n];
  Complex inertia = clamped ? -F : Complex{};
  for (std::size_t k = n; k-- > 0;) {
    inertia += omega * omega * masses[k] * Y[k + 1];
    Z[k] = inertia / d[k];
  }
}

}  // namespace dwell
