#include "core/result/moved.hpp"

#include <cmath>
#include <numbers>

#include "core/base/student.hpp"

namespace dwell {
namespace {

// The z beyond which, on both sides, this part of a normal distribution lies. 0 < part < 1.
double two_sided(double part) noexcept {
  double z = kNormal95;
  // Newton's steps towards ln erfc(z / √2) = ln part: that is nearly a parabola, so a few suffice.
  for (int i = 0; i < 30; ++i) {
    const double tail = std::erfc(z / std::numbers::sqrt2);
    const double slope = -2.0 * std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
    const double step = tail * std::log(tail / part) / slope;
    z -= step;
    if (std::abs(step) < 1e-13) break;
  }
  return z;
}

}  // namespace

double moved_beyond(std::size_t compared) noexcept {
  if (compared <= 1) return 1.0;
  return two_sided(-std::expm1(std::log1p(-kFalselyMoved) / static_cast<double>(compared))) / kNormal95;
}

double moved_beyond(const Dwell& dwell) noexcept {
  std::size_t numbers = 0;
  for (const ElementEstimate& element : dwell.elements) numbers += element.identifiable ? 2 : 0;
  return numbers > 0 ? moved_beyond(numbers) : kNaN;
}

}  // namespace dwell
