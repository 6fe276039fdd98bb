#include "core/fit/scatter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/fit/blocks.hpp"

namespace dwell {
namespace {

constexpr double kSureOfRatio = 2.0;  // standard deviations of the ratio beyond which it is no chance

// Deviation of the fundamental in one stretch: least squares on the residuals of the whole fit.
PhasorStretch stretch_of(const ChannelMoments& sums, int harmonics, const HarmonicFit& fit, double reference) noexcept {
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
  const Eigen::Matrix2d inverse = (0.5 * information).inverse();
  const Eigen::Vector2d off = inverse * score;
  return {true, {off(0), off(1)}, fit.sigma2 * inverse.trace(), score.dot(off) / fit.sigma2};
}

// sum: Σ χ² over so many stretches.
Scatter scatter_from(double sum, double stretches) noexcept {
  Scatter scatter;
  if (stretches < 3) return scatter;
  scatter.dof = 2 * (stretches - 1);
  scatter.ratio = sum / scatter.dof;
  return scatter;
}

}  // namespace

bool Scatter::shows() const noexcept { return dof > 0 && ratio >= 1 + kSureOfRatio * std::sqrt(2 / dof); }

double Scatter::widens() const noexcept {
  if (!shows()) return 1.0;
  return ratio * (ratio > kUnsteady ? dof / 2 + 1 : 1.0);
}

std::vector<std::vector<PhasorStretch>> phasor_stretches(const Blocks& blocks, int from, int to, int harmonics,
                                                         std::span<const HarmonicFit* const> fits, double omega,
                                                         std::int64_t t_ref_ns, Totals& scratch) {
  std::vector<std::vector<PhasorStretch>> stretches(fits.size());
  int quarters = 0;
  for (int i = from; i < to; ++i) quarters += blocks.block(i).quarters;
  const int wanted = std::max(kQuarters, quarters / kStretches);
  for (int first = from, i = from, held = 0; i < to; ++i) {
    held += blocks.block(i).quarters;
    if (held < wanted) continue;
    blocks.sum(first, i + 1, omega, t_ref_ns, scratch);
    for (std::size_t c = 0; c < fits.size(); ++c) {
      const HarmonicFit& fit = *fits[c];
      const ChannelMoments sums = scratch.channel(static_cast<int>(c));
      const bool fitted = fit.usable && fit.sigma2 > 0 && sums.instants[0] > 2 * harmonics + 1;
      stretches[c].push_back(fitted ? stretch_of(sums, harmonics, fit, blocks.reference(static_cast<int>(c)))
                                    : PhasorStretch{});
    }
    first = i + 1;
    held = 0;
  }
  return stretches;
}

Scatter scatter_of(std::span<const PhasorStretch> stretches) noexcept {
  double sum = 0.0, count = 0.0;
  for (const PhasorStretch& stretch : stretches) {
    if (!stretch.usable) continue;
    sum += stretch.chi_squared;
    count += 1;
  }
  return scatter_from(sum, count);
}

Scatter scatter_of_sum(const Eigen::Ref<const Eigen::VectorXcd>& weights,
                       std::span<const std::vector<PhasorStretch>> channels) noexcept {
  std::size_t longest = 0;
  for (const auto& stretches : channels) longest = std::max(longest, stretches.size());
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < longest; ++i) {
    std::complex<double> off = 0.0;
    double variance = 0.0;
    bool usable = true;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const std::complex<double> w = weights(static_cast<Eigen::Index>(c));
      if (w == 0.0) continue;
      usable = usable && i < channels[c].size() && channels[c][i].usable;
      if (!usable) break;
      off += w * channels[c][i].off;
      variance += std::norm(w) * channels[c][i].variance;
    }
    if (!usable || !(variance > 0)) continue;
    sum += 2 * std::norm(off) / variance;
    count += 1;
  }
  return scatter_from(sum, count);
}

}  // namespace dwell
