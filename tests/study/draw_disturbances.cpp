#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "tests/study/draw_parts.hpp"

namespace dwell::study {
namespace {

// Samples of a dwell, roughly: for the study to take no hours, slow rigs with many channels are sampled less often, but
// for one in eight, so that every rig meets every rate.
constexpr double kUsualSamples = 6e4, kMostSamples = 3e5, kDense = 0.125;

// Of a channel's own amplitude, but not below a tenth of what a displacement transducer on the table would have, or of
// what the force would be if the last mass moved as the table.
double scale_of_noise(const Case& about, int c, double table_amplitude) {
  const Sensor& sensor = about.sensors[static_cast<std::size_t>(c)];
  const double omega = kTwoPi * about.frequency_hz;
  double usual = table_amplitude;
  if (sensor.measures == Quantity::velocity) usual *= omega;
  if (sensor.measures == Quantity::acceleration) usual *= omega * omega;
  if (sensor.measures == Quantity::force) usual *= about.chain.stiffness.back();
  return std::max(std::abs(about.motion->phasor(c, 1)), 0.1 * usual);
}

}  // namespace

void draw_sampling(Draws& draws, Case& about, double fewest, double most) {
  const double periods = 60 + 8 * about.motion->time_constant_s() * about.frequency_hz + about.hold_periods;
  const double samples = draws.chance(kDense) ? kMostSamples : kUsualSamples;
  most = std::clamp(samples / (periods * about.channels()), std::min(most, 1.2 * fewest), most);
  const double common = draws.log_uniform(fewest, most);
  const bool same = draws.chance(0.7);
  const double skew = draws.chance(0.8) ? draws.uniform(0, 1.0 / about.channels()) : 0.0;
  const double jitter = draws.chance(0.7) ? draws.uniform(0, 0.5) : 0.0;
  const double start = draws.uniform(0, 1);
  for (int c = 0; c < about.channels(); ++c) {
    Line& line = about.lines[static_cast<std::size_t>(c)];
    line.rate_hz = about.frequency_hz * (same ? common : draws.log_uniform(fewest, most));
    line.phase = start + c * skew;
    line.jitter = jitter;
  }
}

void draw_noise(Draws& draws, Case& about, double table_amplitude) {
  const double common = draws.log_uniform(2e-4, 2e-2);
  const double mains_hz = 50 + draws.uniform(-0.05, 0.05);  // one grid feeds all
  for (int c = 0; c < about.channels(); ++c) {
    Line& line = about.lines[static_cast<std::size_t>(c)];
    const double scale = scale_of_noise(about, c, table_amplitude);
    line.sigma = scale * std::clamp(common * draws.log_uniform(0.5, 2), 2e-4, 2e-2);
    line.mean = scale * draws.uniform(-1, 1);
    const bool all = about.population == Population::steady;
    if (about.population == Population::hum || (all && draws.chance(0.5))) {
      // Slow beats of hum on the table must stay apart from a step of three tolerances in an unchanged drive.
      line.hum = scale * draws.log_uniform(5e-4, all && c == 0 ? about.rig.tolerance : 2e-2);
      line.hum_hz = mains_hz;
      line.hum_phase = draws.uniform(0, kTwoPi);
    }
    if (about.population == Population::quantized || about.population == Population::coarse ||
        (all && draws.chance(0.5))) {
      // 12 bits over a range of which the motion fills a part.
      const double full = scale * draws.log_uniform(2.5, 25);
      line.step = full / 4096;
      const bool half = about.population == Population::coarse ? false : !all || draws.chance(0.5);
      line.sigma = line.step * (half ? draws.log_uniform(0.5, 3) : draws.uniform(0, 0.5));
    }
  }
}

// The rig file states what is meant; the rig is off by an error of the stated uncertainty.
void draw_type_b(Draws& draws, Case& about) {
  const double omega = kTwoPi * about.frequency_hz;
  about.rig.excitation.clock_u = draws.log_uniform(2e-5, 5e-4);
  about.clock_error = about.rig.excitation.clock_u * draws.normal();
  const bool two_devices = draws.chance(0.5);
  if (two_devices) about.rig.devices.resize(2);
  for (Device& device : about.rig.devices) {
    device.delay_s = draws.uniform(0, 0.02) / omega;
    device.delay_u_s = draws.log_uniform(2e-4, 5e-3) / omega;
  }
  std::vector<double> late_s, shift_s, half_s;
  for (const Device& device : about.rig.devices) {
    late_s.push_back(device.delay_s + device.delay_u_s * draws.normal());
    half_s.push_back(draws.chance(0.5) ? draws.log_uniform(2e-4, 5e-3) / omega : 0.0);
    shift_s.push_back(half_s.back() * draws.uniform(-1, 1));
  }
  for (std::size_t c = 0; c < about.sensors.size(); ++c) {
    Channel& stated = about.rig.channels[c];
    Sensor& truly = about.sensors[c];
    stated.device = two_devices ? draws.integer(0, 1) : 0;
    const auto device = static_cast<std::size_t>(stated.device);
    stated.scale_u = draws.log_uniform(3e-4, 1e-2);
    truly.gain = 1 + stated.scale_u * draws.normal();
    stated.delay_s = draws.uniform(0, 0.05) / omega;
    stated.delay_u_s = draws.log_uniform(2e-4, 5e-3) / omega;
    truly.delay_s = late_s[device] + stated.delay_s + stated.delay_u_s * draws.normal();
    about.lines[c].shift_s = shift_s[device];
    about.half_ns[c] = static_cast<std::uint32_t>(std::llround(1e9 * half_s[device]));
    if (draws.chance(0.5)) {
      const double hz = about.frequency_hz * draws.log_uniform(4, 20);
      stated.lowpass = {draws.chance(0.5) ? FilterKind::butterworth : FilterKind::rc, draws.integer(1, 4), hz,
                        hz * draws.log_uniform(2e-3, 2e-2)};
      truly.lowpass = stated.lowpass;
      truly.lowpass.hz += stated.lowpass.hz_u * draws.normal();
    }
  }
  for (double& mass : about.rig.masses) {
    about.rig.mass_u.push_back(mass * draws.log_uniform(3e-4, 1e-2));
    mass += about.rig.mass_u.back() * draws.normal();
  }
}

}  // namespace dwell::study
