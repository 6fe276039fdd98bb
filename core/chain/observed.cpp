#include "core/chain/observed.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/complex.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::VectorXd;
using Index = Eigen::Index;

// T of X = T(s)·o.
Complex transfer(const Rig& rig, const Channel& channel, Complex s) {
  return std::pow(s, derivative_order(channel.measures)) * response(channel, device_delay_s(rig, channel), s) *
         (channel.force_on_mass ? -1.0 : 1.0);
}
Complex transfer(const Rig& rig, const Channel& channel, double omega) {
  return transfer(rig, channel, Complex{0.0, omega});
}

}  // namespace

Complex as_observed(const Rig& rig, int channel, Complex X, double omega, int h) {
  return X / transfer(rig, rig.channels[static_cast<std::size_t>(channel)], h * omega);
}

Complex as_observed(const Rig& rig, int channel, Complex a, Complex s) {
  return a / transfer(rig, rig.channels[static_cast<std::size_t>(channel)], s);
}

Complex observed_too_small(const Rig& rig, const ReadingError& error, Complex s) {
  constexpr double kStep = 1e-4;  // relative step of a corner for a central difference
  const Channel& channel = rig.channels[static_cast<std::size_t>(error.channel)];
  const auto by_corner = [&](Filter filter, bool high, double change_hz) {
    if (change_hz == 0) return Complex{};
    const double hz = filter.hz;
    filter.hz = hz * (1 + kStep);
    const Complex above = filter_response(filter, high, s);
    filter.hz = hz * (1 - kStep);
    return std::log(above / filter_response(filter, high, s)) / (2 * kStep * hz) * change_hz;
  };
  return error.relative + s * error.late_s - by_corner(channel.lowpass, false, error.lowpass_hz) -
         by_corner(channel.highpass, true, error.highpass_hz);
}

VectorXd observation_weights(const Rig& rig, const std::vector<Evidence>& evidence, double omega) {
  VectorXd weights = VectorXd::Zero(static_cast<Index>(rig.channels.size()));
  // The largest weight of the displacements and of the forces each becomes 1. A common factor changes nothing.
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    if (!evidence[c].usable || rig.channels[c].measures == Quantity::auxiliary) continue;
    const Complex T = transfer(rig, rig.channels[c], omega);
    const double noise = std::sqrt(0.5 * evidence[c].widened * evidence[c].covariance.trace());
    const double size = std::abs(evidence[c].X[0]);
    // 1e-12 bounds the weight of a reading without noise.
    weights(static_cast<Index>(c)) =
        std::abs(T) / std::hypot(noise, rig.channels[c].scale_u * size, 1e-12 * size + 1e-300);
  }
  const double largest = weights.maxCoeff();
  for (const bool force : {false, true}) {
    double scale = 0.0;
    for (std::size_t c = 0; c < rig.channels.size(); ++c)
      if ((rig.channels[c].measures == Quantity::force) == force)
        scale = std::max(scale, weights(static_cast<Index>(c)));
    for (std::size_t c = 0; c < rig.channels.size(); ++c)
      if ((rig.channels[c].measures == Quantity::force) == force && scale > 0) weights(static_cast<Index>(c)) /= scale;
  }
  return largest > 0 ? weights : VectorXd::Zero(weights.size());
}

}  // namespace dwell
