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

// before: null: the dwell before does not have the element.
CoefficientMove move_of(const ElementEstimate* before, const ElementEstimate& now, Coefficient ElementEstimate::*which,
                        double beyond) noexcept {
  if (before == nullptr || !before->identifiable) return {};
  const Coefficient &was = before->*which, &is = now.*which;
  if (!std::isfinite(was.value) || !std::isfinite(is.value) || was.value == 0.0) return {};
  CoefficientMove move;
  move.change = (is.value - was.value) / std::abs(was.value);
  move.U95 = std::hypot(is.U95, was.U95) / std::abs(was.value);
  move.moved = std::abs(move.change) > beyond * move.U95;
  return move;
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

std::vector<ElementMove> moves_since(const Dwell& before, const Dwell& now) {
  std::vector<ElementMove> moves;
  const double beyond = moved_beyond(now);
  for (const ElementEstimate& element : now.elements) {
    if (!element.identifiable) continue;
    const ElementEstimate* const was = element_of(before, element.k);
    moves.push_back({element.k, move_of(was, element, &ElementEstimate::stiffness, beyond),
                     move_of(was, element, &ElementEstimate::damping, beyond)});
  }
  return moves;
}

}  // namespace dwell
