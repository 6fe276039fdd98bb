#include "core/seen_modes.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

// Of the longer of 1/T and the decay rate: an error of a pole that turns or shrinks its mode by that part while it is
// seen. Beyond, its errors are not normal any more. Doubled, poles of weak modes take part that are off by more than
// their uncertainty says; halved, faults go unseen that the data do resolve.
constexpr double kResolved = 0.2;
// Standard deviations that the last step would still have moved a pole: a fit that far from its optimum tells a pole
// that is off by more than its uncertainty says: by so many times that step, either way.
constexpr double kSettledPole = 1.0, kUnsettled = 10.0;
// Standard deviations of an amplitude from which a channel has a say in a pole: below, its residuals tell of others.
constexpr double kStandsOut = 3.0;

}  // namespace

SeenModes::SeenModes(int channels) {
  for (SeenMode& mode : modes_) {
    mode.amplitude.resize(static_cast<std::size_t>(channels));
    mode.u_amplitude.resize(static_cast<std::size_t>(channels));
  }
}

void SeenModes::take(const ModalFit& fit, std::span<const std::complex<double>> refined, std::int64_t until_ns,
                     std::span<const double> left_over) noexcept {
  count_ = 0;
  const double seen_s = 1e-9 * static_cast<double>(until_ns - fit.t0_ns());
  for (std::size_t m = 0; m < refined.size(); ++m) {
    const std::complex<double> pole = refined[m], step = pole - fit.poles()[m];
    if (!(pole.real() < 0) || !(pole.imag() > 0) || !fit.shows(m)) continue;
    // A pole that still moves is known less well than the data would allow.
    const Eigen::Vector2d moves(step.real(), step.imag());
    const Eigen::Matrix2d of_data = fit.pole_covariance(m);
    const bool settled = moves.dot(of_data.inverse() * moves) < kSettledPole * kSettledPole;
    const double scale = std::max(-pole.real(), 1 / std::max(1e-9, seen_s));
    double moved = 0.0;  // at most, by what the fit leaves over, relative to the scale; squared
    for (std::size_t c = 0; c < left_over.size(); ++c) {
      const int channel = static_cast<int>(c);
      if (!fit.usable(channel) || !(left_over[c] > 0)) continue;
      const double a = std::abs(fit.amplitude(channel, m));
      if (a > kStandsOut * fit.u_amplitude(channel, m)) moved = std::max(moved, 2 * left_over[c] / (a * a));
    }
    if (!settled) moved += kUnsettled * kUnsettled * moves.squaredNorm() / (scale * scale);
    const Eigen::Matrix2d covariance =
        of_data + moves * moves.transpose() + moved * scale * scale * Eigen::Matrix2d::Identity();
    if (!(std::sqrt(covariance.trace()) < kResolved * scale)) continue;
    SeenMode& mode = modes_[count_++];
    mode.pole = pole;
    mode.covariance = covariance;
    for (std::size_t c = 0; c < mode.amplitude.size(); ++c) {
      const int channel = static_cast<int>(c);
      mode.amplitude[c] = fit.usable(channel) ? std::abs(fit.amplitude(channel, m)) : 0.0;
      mode.u_amplitude[c] = fit.usable(channel) ? fit.u_amplitude(channel, m) : 0.0;
    }
  }
}

}  // namespace dwell
