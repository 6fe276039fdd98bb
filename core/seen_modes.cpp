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
// that is off by more than its uncertainty says.
constexpr double kSettledPole = 1.0;

}  // namespace

SeenModes::SeenModes(int channels) {
  for (SeenMode& mode : modes_) {
    mode.amplitude.resize(static_cast<std::size_t>(channels));
    mode.u_amplitude.resize(static_cast<std::size_t>(channels));
  }
}

void SeenModes::take(const ModalFit& fit, std::span<const std::complex<double>> refined,
                     std::int64_t until_ns) noexcept {
  count_ = 0;
  const double seen_s = 1e-9 * static_cast<double>(until_ns - fit.t0_ns());
  for (std::size_t m = 0; m < refined.size(); ++m) {
    const std::complex<double> pole = refined[m], step = pole - fit.poles()[m];
    if (!(pole.real() < 0) || !(pole.imag() > 0) || !fit.shows(m)) continue;
    // A pole that still moves is known less well than the data would allow.
    const Eigen::Vector2d moves(step.real(), step.imag());
    const Eigen::Matrix2d of_data = fit.pole_covariance(m);
    if (!(moves.dot(of_data.inverse() * moves) < kSettledPole * kSettledPole)) continue;
    const Eigen::Matrix2d covariance = of_data + moves * moves.transpose();
    const double scale = std::max(-pole.real(), 1 / std::max(1e-9, seen_s));
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
