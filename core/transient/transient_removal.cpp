#include "core/transient/transient_removal.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

constexpr double kNegligible = 1e-3;        // a mode is negligible below this part of the tolerance …
constexpr double kNegligibleOfNoise = 0.2;  // … or of the phasor's uncertainty, whichever is larger

}  // namespace

TransientRemoval::TransientRemoval(const Rig& rig, HoldFit& fit)
    : rig_(rig), fit_(fit), overlap_(static_cast<std::size_t>(fit.channels())) {
  for (auto& B : overlap_) B.setZero(2, fit.fit().modal_regressors());
}

double TransientRemoval::negligible(int channel) const noexcept {
  const ModalFit& fit = fit_.fit();
  return std::max(kNegligible * rig_.tolerance * std::abs(fit.phasor(channel, 1)),
                  kNegligibleOfNoise * std::sqrt(fit.variance(channel) * 2 / fit.samples(channel)));
}

// A mode that has become negligible in every channel is evaluated no more.
void TransientRemoval::fade_modes(std::int64_t from_ns) noexcept {
  ModalFit& fit = fit_.fit();
  for (std::size_t m = 0; m < fit.poles().size(); ++m) {
    if (fit.poles()[m].real() == 0) continue;
    double fades_s = 0.0;
    for (int c = 0; c < fit_.channels(); ++c)
      if (fit.usable(c)) {
        const double most = fit.most(c, m, from_ns) / negligible(c);
        if (most > 1) fades_s = std::max(fades_s, std::log(most) / -fit.poles()[m].real());
      }
    fit.fade(m, from_ns + to_ns(std::min(fades_s, rig_.memory_s)));
  }
}

void TransientRemoval::begin(std::int64_t from_ns, std::int64_t until_ns) noexcept {
  fade_modes(from_ns);
  const ModalFit& fit = fit_.fit();
  for (std::size_t m = 0; m < fit.poles().size(); ++m)
    if (fit.poles()[m].real() < 0) until_ns = std::max(until_ns, fit.faded_ns(m));
  until_ns_ = until_ns;
  for (auto& B : overlap_) B.setZero();
}

double TransientRemoval::transient(int channel, std::int64_t t_ns) noexcept {
  const bool none = !until_ns_ || t_ns >= *until_ns_ || !fit_.fit().usable(channel);
  return none ? 0.0 : fit_.fit().disturbance(channel, t_ns);
}

double TransientRemoval::clean(int channel, std::int64_t t_ns, double value) noexcept {
  if (!until_ns_ || t_ns >= *until_ns_ || !fit_.fit().usable(channel)) return value;
  value -= fit_.fit().disturbance(channel, t_ns);
  fit_.fit().overlap_at(t_ns, overlap_[static_cast<std::size_t>(channel)]);
  return value;
}

Eigen::Matrix2d TransientRemoval::covariance(int channel, double samples) const noexcept {
  return 4 / (samples * samples) * fit_.fit().spread(channel, overlap_[static_cast<std::size_t>(channel)]);
}

Eigen::Vector2d TransientRemoval::taken_out(int channel) const noexcept {
  return fit_.fit().taken_out(channel, overlap_[static_cast<std::size_t>(channel)]);
}

}  // namespace dwell
