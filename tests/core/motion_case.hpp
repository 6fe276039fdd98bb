// Rigs, readings and unknowns for the tests of core/motion.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/motion/likelihood.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {

// Stated uncertainties of every kind, a filter, a delay, transducers of every quantity.
inline Rig rig_of_all_kinds() {
  Rig rig = rig_of(clamped_chain(), 4.0);
  rig.mass_u = {0.01, 0.02};
  rig.excitation.clock_u = 5e-5;
  rig.devices.push_back({.name = "amplifier", .delay_s = 1e-3, .delay_u_s = 1e-4});
  for (Channel& channel : rig.channels) channel.device = 0;
  Channel& y1 = rig.channels[1];
  y1.relative_to = 0;
  y1.scale_u = 0.002;
  y1.delay_s = 4e-4;
  y1.delay_u_s = 1e-4;
  Channel& y2 = rig.channels[2];
  y2.measures = Quantity::acceleration;
  y2.lowpass = {FilterKind::butterworth, 2, 60.0, 1.0, true};
  y2.highpass = {FilterKind::rc, 1, 0.5, 0.02, true};
  rig.channels[3].scale_u = 0.005;
  Channel velocity = rig.channels[0];
  velocity.name = "v1";
  velocity.at = 1;
  velocity.measures = Quantity::velocity;
  rig.channels.push_back(velocity);
  return rig;
}

// What the channels of a rig without filters read of a driven chain from `from_s` on, noise sigma[c] added, channel c
// read c·skew_s after channel 0, its stated delay late.
inline MotionData readings_of(const Rig& rig, DrivenChain& chain, double from_s, double until_s, double rate_hz,
                              const std::vector<double>& sigma, std::uint64_t seed, double skew_s = 0.0) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  MotionData data;
  const MotionModel delays(rig, {});
  for (int i = 0; from_s + i / rate_hz < until_s; ++i)
    for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
      const double t = from_s + i / rate_hz + c * skew_s - delays.delay_s(c);
      if (t < 0) continue;
      const double noise = sigma[static_cast<std::size_t>(c)] * normal(rng);
      data.readings.push_back({to_ns(t), c, exact_reading(rig, chain.at(to_s(to_ns(t))), c) + noise});
    }
  std::stable_sort(data.readings.begin(), data.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  return data;
}

// A part of the size that each channel has in the steady motion.
inline std::vector<double> part_of_steady(const Rig& rig, const Chain& chain, const Drive& drive, double part) {
  DrivenChain steady(chain, drive, DrivenChain::Start::steady);
  std::vector<double> out(rig.channels.size(), 0.0);
  for (int i = 0; i < 64; ++i)
    for (std::size_t c = 0; c < out.size(); ++c)
      out[c] = std::max(
          out[c], part * std::abs(exact_reading(rig, steady.at(i / 64.0 / drive.frequency_hz), static_cast<int>(c))));
  return out;
}

// The chain's coefficients, these noises and that intensity; departures from what is stated 0.
inline Eigen::VectorXd theta_of(const std::vector<Parameter>& parameters, const Chain& chain,
                                const std::vector<double>& sigma, double ln_q) {
  Eigen::VectorXd theta(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t a = 0; a < parameters.size(); ++a) {
    const Parameter& p = parameters[a];
    const auto i = static_cast<std::size_t>(p.index);
    theta(static_cast<Eigen::Index>(a)) = p.what == Unknown::stiffness   ? chain.stiffness[i]
                                          : p.what == Unknown::damping   ? chain.damping[i]
                                          : p.what == Unknown::noise     ? std::log(sigma[i])
                                          : p.what == Unknown::intensity ? ln_q
                                                                         : 0.0;
  }
  return theta;
}

// The state of a model without filters in that motion, the table's third derivative taken as 0.
inline Eigen::VectorXd state_of(const MotionModel& model, const ChainMotion& motion) {
  const double omega0 = kTwoPi * model.rig().excitation.frequency_hz;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.states());
  x(0) = motion.y[0];
  x(1) = motion.velocity[0] / omega0;
  x(2) = motion.acceleration[0] / (omega0 * omega0);
  const int n = model.rig().mass_count(), table = model.table_states();
  for (int k = 1; k <= n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    x(table + k - 1) = motion.y[i] - motion.y[i - 1];
    x(table + n + k - 1) = (motion.velocity[i] - motion.velocity[i - 1]) / omega0;
  }
  return x;
}

}  // namespace dwell
