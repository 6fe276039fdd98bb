#include "core/transient/residual_noise.hpp"

#include <algorithm>

#include "core/base/chance.hpp"

namespace dwell {

void ResidualNoise::begin_hold() noexcept {
  for (PerChannel& of : channels_) of = {};
}

void ResidualNoise::learn(int channel, double squares, double freedom) noexcept {
  PerChannel& of = channels_[static_cast<std::size_t>(channel)];
  const double before = std::min(of.freedom, 8 * freedom);
  if (!(before + freedom > 0)) return;
  of.variance = ((before > 0 ? before * of.variance : 0.0) + squares) / (before + freedom);
  of.freedom = before + freedom;
}

double ResidualNoise::smallest_variance(int channel, const ModalFit& fit) const noexcept {
  const PerChannel& of = at(channel);
  return std::min({fit.variance(channel), of.variance, of.in_later > 0 ? of.later : INFINITY});
}

void ResidualNoise::compare_halves(HoldFit& fit, std::int64_t now_ns) noexcept {
  const std::int64_t first_ns = fit.fit().t0_ns(), middle_ns = first_ns + (now_ns - first_ns) / 2;
  for (PerChannel& of : channels_) of.earlier = of.later = of.in_earlier = of.in_later = 0.0;
  fit.each_residual(first_ns, [&](const SampleHistory::Sample& sample, double r) {
    PerChannel& of = channels_[static_cast<std::size_t>(sample.channel)];
    (sample.t_ns < middle_ns ? of.earlier : of.later) += r * r;
    (sample.t_ns < middle_ns ? of.in_earlier : of.in_later) += 1.0;
  });
  // Each half accounts for half of the fit's parameters.
  const double half = 0.5 * static_cast<double>(fit.fit().parameters());
  for (PerChannel& of : channels_) {
    of.earlier /= std::max(1.0, of.in_earlier - half);
    of.later /= std::max(1.0, of.in_later - half);
  }
}

double ResidualNoise::unexplained(int channel, const ModalFit& fit, const HoldNow& now) const noexcept {
  const PerChannel& of = at(channel);
  // Instants known to ± h add residuals of variance (ω |Y|)²/2 · h²/3.
  const double by_refresh = std::norm(now.omega * now.channel(channel).refresh_half_s * fit.phasor(channel, 1)) / 6;
  const double by_noise = fit.variance(channel) - by_refresh -
                          of.variance * (1 + sigmas::kShown * std::sqrt(2 / std::max(1.0, of.freedom)));
  const double by_decay =
      of.earlier -
      of.later * (1 + sigmas::kShown * std::sqrt(2 / std::max(1.0, of.in_earlier) + 2 / std::max(1.0, of.in_later)));
  return std::max(by_noise, by_decay);
}

bool ResidualNoise::explained(const ModalFit& fit, const HoldNow& now) const noexcept {
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (const int channel = static_cast<int>(c);
        fit.usable(channel) && !now.channels[c].imposed && unexplained(channel, fit, now) > 0)
      return false;
  return true;
}

}  // namespace dwell
