#include "core/fit/folding.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/rounding.hpp"

namespace dwell {
namespace {

// Shifts tried on either side, 1e-4 of the rate apart: finer than a drive's frequency is known.
constexpr int kRatesTried = 100;

}  // namespace

Folding worst_folding(double rate_hz, double drive_hz, int fitted) noexcept {
  const double ratio = rate_hz / drive_hz;
  Folding worst;
  for (int m = fitted + 1; m <= kFoldedOrder; ++m) {
    const double turns = std::round(m / ratio);
    if (turns < 1) continue;  // not folded
    const double read_as = std::abs(m - turns * ratio);
    const int onto = static_cast<int>(std::min(std::round(read_as), static_cast<double>(fitted)));
    const double apart_hz = std::abs(read_as - onto) * drive_hz;
    const Folding folding{m, onto, apart_hz};
    if (folding.distance_hz() < worst.distance_hz() - kOnlyRounding * drive_hz) worst = folding;
  }
  return worst;
}

double rate_beside_foldings(double rate_hz, double drive_hz, int fitted) noexcept {
  const double clear_hz = kClearOfHarmonics * drive_hz;
  double best_hz = rate_hz, farthest_hz = worst_folding(rate_hz, drive_hz, fitted).distance_hz();
  const double slowest_hz = 2.0 * (fitted + 1) * drive_hz;
  if (farthest_hz >= clear_hz || rate_hz < slowest_hz) return rate_hz;
  for (int step = 1; step <= kRatesTried; ++step) {
    for (const int sign : {-1, 1}) {  // the slower rate first: it loads the line less
      const double tried_hz = rate_hz * (1.0 + sign * step * kRateShift / kRatesTried);
      if (tried_hz < slowest_hz) continue;
      const double far_hz = worst_folding(tried_hz, drive_hz, fitted).distance_hz();
      if (far_hz <= farthest_hz + kOnlyRounding * drive_hz) continue;
      farthest_hz = far_hz;
      best_hz = tried_hz;
    }
  }
  return best_hz;
}

}  // namespace dwell
