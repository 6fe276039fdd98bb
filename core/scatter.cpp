#include "core/scatter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cstdlib>

namespace dwell {
namespace {

constexpr int kStretches = 12;
constexpr int kPeriod = 4;  // quarters

// χ² (two degrees of freedom) of one stretch's residuals in the direction of the fundamental.
double chi_squared(const ChannelMoments& sums, int harmonics, const HarmonicFit& fit, double reference) noexcept {
  const int instants = 2 * harmonics + 1, readings = harmonics + 1;
  const auto c = [&](int k) { return sums.instants[moments::cosine(instants, 0, std::abs(k))]; };
  const auto s = [&](int k) { return (k < 0 ? -1 : 1) * sums.instants[moments::sine(instants, 0, std::abs(k))]; };
  const double b = fit.mean - reference;
  Eigen::Vector2d score(sums.readings[moments::sine(readings, 0, 1)] - b * s(1),
                        sums.readings[moments::cosine(readings, 0, 1)] - b * c(1));
  for (int h = 1; h <= harmonics; ++h) {
    const double p = fit.X[static_cast<std::size_t>(h - 1)].real(), q = fit.X[static_cast<std::size_t>(h - 1)].imag();
    score(0) -= 0.5 * (p * (c(1 - h) - c(1 + h)) + q * (s(1 + h) + s(1 - h)));
    score(1) -= 0.5 * (p * (s(1 + h) + s(h - 1)) + q * (c(1 - h) + c(1 + h)));
  }
  Eigen::Matrix2d information;
  information << c(0) - c(2), s(2), s(2), c(0) + c(2);
  return score.dot((0.5 * information).inverse() * score) / fit.sigma2;
}

}  // namespace

Scatter phasor_scatter(const Blocks& blocks, int from, int to, int channel, int harmonics, const HarmonicFit& fit,
                       double omega, std::int64_t t_ref_ns, Totals& scratch) noexcept {
  Scatter scatter;
  if (!fit.usable || !(fit.sigma2 > 0) || from >= to) return scatter;
  int quarters = 0;
  for (int i = from; i < to; ++i) quarters += blocks.block(i).quarters;
  const int wanted = std::max(kPeriod, quarters / kStretches);
  double sum = 0.0, stretches = 0.0;
  for (int first = from, i = from, held = 0; i < to; ++i) {
    held += blocks.block(i).quarters;
    if (held < wanted) continue;
    blocks.sum_channel(channel, first, i + 1, omega, t_ref_ns, scratch);
    const ChannelMoments sums = scratch.channel(channel);
    if (sums.instants[0] > 2 * harmonics + 1) {
      sum += chi_squared(sums, harmonics, fit, blocks.reference(channel));
      stretches += 1;
    }
    first = i + 1;
    held = 0;
  }
  if (stretches < 3) return scatter;
  scatter.dof = 2 * (stretches - 1);
  scatter.ratio = sum / scatter.dof;
  return scatter;
}

}  // namespace dwell
