#include "core/motion/whiteness.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {

Whiteness whiteness_of(const std::vector<MotionInnovation>& innovations) {
  const auto count = static_cast<double>(innovations.size());
  Whiteness out;
  if (innovations.size() < 5 * kWhitenessLags) return out;
  double power = 0.0, statistic = 0.0;
  for (const MotionInnovation& one : innovations) power += one.normalized * one.normalized;
  for (std::size_t lag = 1; lag <= kWhitenessLags; ++lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < innovations.size(); ++i)
      sum += innovations[i].normalized * innovations[i - lag].normalized;
    const double rho2 = sum * sum / (power * power);
    statistic += rho2 / (count - static_cast<double>(lag));
    out.squares += count * rho2;
    out.largest = std::max(out.largest, std::sqrt(rho2));
  }
  out.ljung_box = statistic * count * (count + 2);
  // χ² of an even number of degrees of freedom, in closed form.
  double term = 1.0, sum = 1.0;
  for (int k = 1; k < kWhitenessLags / 2; ++k) sum += term *= 0.5 * out.ljung_box / k;
  out.p = std::exp(-0.5 * out.ljung_box) * sum;
  return out;
}

}  // namespace dwell
