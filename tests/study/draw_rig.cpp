#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/study/draw_parts.hpp"

namespace dwell::study {
namespace {

constexpr double kLightest = 0.003, kHeaviest = 0.2;  // damping ratios

double ratio_of(Complex lambda) { return -lambda.real() / std::abs(lambda); }

// What lies beyond mass k, mass k held: at its natural frequencies mass k is a node.
Chain beyond(const Chain& chain, std::size_t k) {
  const auto from = static_cast<std::ptrdiff_t>(k);
  return {chain.boundary,
          {chain.masses.begin() + from, chain.masses.end()},
          {chain.stiffness.begin() + from, chain.stiffness.end()},
          {chain.damping.begin() + from, chain.damping.end()}};
}

// Modes of positive frequency, ascending; empty if one is overdamped or out of the range of damping ratios.
std::vector<Complex> fit_modes(const Chain& chain) {
  std::vector<Complex> modes;
  for (const Complex& lambda : natural_values(chain)) {
    if (lambda.imag() == 0 || ratio_of(lambda) < 0.999 * kLightest || ratio_of(lambda) > 1.001 * kHeaviest) return {};
    if (lambda.imag() > 0) modes.push_back(lambda);
  }
  std::sort(modes.begin(), modes.end(), [](Complex a, Complex b) { return a.imag() < b.imag(); });
  return modes;
}

// A chain with masses and stiffnesses of any proportion, its lightest or heaviest damped mode at a drawn ratio.
Chain draw_proportions(Draws& draws, int n, Boundary boundary) {
  for (;;) {
    Chain chain{boundary, {}, {}, {}};
    for (int k = 0; k < n; ++k) chain.masses.push_back(draws.log_uniform(3, 30));
    for (int e = 0; e < chain.element_count(); ++e) {
      chain.stiffness.push_back(1e4 * draws.log_uniform(0.3, 3));
      chain.damping.push_back(chain.stiffness.back() * draws.log_uniform(0.5, 2) * 1e-6);
    }
    double lightest = INFINITY, heaviest = 0.0;
    for (const Complex& lambda : natural_values(chain)) {
      lightest = std::min(lightest, ratio_of(lambda));
      heaviest = std::max(heaviest, ratio_of(lambda));
    }
    const double wanted = draws.log_uniform(kLightest, kHeaviest);
    const double more = wanted / (draws.chance(0.5) ? lightest : heaviest);
    for (double& r : chain.damping) r *= more;
    if (!fit_modes(chain).empty()) return chain;
  }
}

}  // namespace

void draw_chain(Draws& draws, Case& about, int most) {
  const int n = draws.integer(1, most);
  about.chain = draw_proportions(draws, n, draws.chance(0.5) ? Boundary::clamped : Boundary::free);
  Chain& chain = about.chain;
  const std::vector<Complex> modes = fit_modes(chain);
  const auto any = static_cast<std::size_t>(draws.integer(0, static_cast<int>(modes.size()) - 1));
  double drive = modes[any].imag();  // rad/s, where the chain as drawn is to be driven
  const double kind = draws.uniform(0, 1);
  if (kind < 0.15) {
    drive *= 1 + draws.uniform(-0.01, 0.01);
    about.remark = "beating ";
  } else if (kind < 0.25) {
    drive = modes.front().imag() * draws.log_uniform(3, 10);
    about.remark = "slow ";
  } else if (kind < 0.35 && n > 1) {
    const Chain rest = beyond(chain, static_cast<std::size_t>(draws.integer(1, n - 1)));
    std::vector<double> omegas;
    for (const Complex& lambda : natural_values(rest))
      if (lambda.imag() > 0) omegas.push_back(std::abs(lambda));
    std::sort(omegas.begin(), omegas.end());
    drive = omegas[static_cast<std::size_t>(draws.integer(0, static_cast<int>(omegas.size()) - 1))];
    about.remark = "node ";
  } else {
    drive *= draws.log_uniform(0.4, 2.5);
  }
  // The same proportions, all frequencies moved so that `drive` becomes the drive's.
  const double faster = kTwoPi * about.frequency_hz / drive;
  for (double& c : chain.stiffness) c *= faster * faster;
  for (double& r : chain.damping) r *= faster;
  about.rig.boundary = chain.boundary;
  about.rig.masses = chain.masses;
}

void draw_channels(Draws& draws, Case& about) {
  const auto add = [&](const Sensor& sensor, const std::string& name) {
    Channel channel;
    channel.name = name;
    channel.device = 0;
    channel.measures = sensor.measures;
    channel.at = sensor.at;
    channel.relative_to = sensor.relative_to;
    channel.unit = sensor.measures == Quantity::force          ? "N"
                   : sensor.measures == Quantity::velocity     ? "m/s"
                   : sensor.measures == Quantity::acceleration ? "m/s2"
                                                               : "m";
    about.rig.channels.push_back(channel);
    about.sensors.push_back(sensor);
  };
  about.rig.devices.resize(1);
  about.rig.devices[0].name = "amplifier";
  const bool others = draws.chance(0.2);
  for (int k = 0; k <= about.chain.mass_count(); ++k) {
    Sensor sensor;
    sensor.at = k;
    if (k > 0 && draws.chance(0.1)) sensor.relative_to = k - 1;
    if (others && k > 0 && draws.chance(0.5))
      sensor.measures = draws.chance(0.5) ? Quantity::velocity : Quantity::acceleration;
    add(sensor, "y" + std::to_string(k));
  }
  if (about.chain.boundary == Boundary::clamped) {
    Sensor force;
    force.measures = Quantity::force;
    force.at = kGround;
    add(force, "reaction");
  }
  about.lines.assign(about.sensors.size(), Line{});
  about.half_ns.assign(about.sensors.size(), 0);
}

}  // namespace dwell::study
