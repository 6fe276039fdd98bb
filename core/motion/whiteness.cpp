#include "core/motion/whiteness.hpp"

#include <cmath>
#include <limits>

namespace dwell {

double ljung_box(const std::vector<MotionInnovation>& innovations) {
  const auto count = static_cast<double>(innovations.size());
  if (innovations.size() < 5 * kWhitenessLags) return std::numeric_limits<double>::quiet_NaN();
  double power = 0.0, statistic = 0.0;
  for (const MotionInnovation& one : innovations) power += one.normalized * one.normalized;
  for (std::size_t lag = 1; lag <= kWhitenessLags; ++lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < innovations.size(); ++i)
      sum += innovations[i].normalized * innovations[i - lag].normalized;
    statistic += sum * sum / (power * power) / (count - static_cast<double>(lag));
  }
  return statistic * count * (count + 2);
}

// χ² of an even number of degrees of freedom, in closed form.
double whiteness_p(double ljung_box) {
  double term = 1.0, sum = 1.0;
  for (int k = 1; k < kWhitenessLags / 2; ++k) sum += term *= 0.5 * ljung_box / k;
  return std::exp(-0.5 * ljung_box) * sum;
}

}  // namespace dwell
