#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/forward.hpp"
#include "tests/study/case.hpp"
#include "tests/study/draw_rig.hpp"

namespace dwell::study {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kMostSamples = 1.5e6;  // of a dwell, roughly: slow rigs with many channels are sampled less often

// The table's motion: fundamental and, in half of the rigs, harmonics as a shaker makes them.
TableMotion draw_table(Draws& draws, double frequency_hz, int harmonics) {
  TableMotion table{frequency_hz, {Complex{draws.log_uniform(2e-4, 5e-3), 0.0}}};
  if (draws.chance(0.5))
    for (int h = 2; h <= harmonics; ++h)
      table.shape.push_back(table.shape[0] * std::polar(draws.log_uniform(0.001, 0.05), draws.uniform(0, kTwoPi)));
  return table;
}

// Any state within a few times what the steady motion amounts to.
MassState draw_state(Draws& draws, const Chain& chain, const TableMotion& table) {
  const double omega = kTwoPi * table.frequency_hz;
  const SteadyResponse steady = steady_response(chain, omega, table.shape[0]);
  MassState state;
  for (std::size_t k = 1; k < steady.Y.size(); ++k) {
    state.y.push_back(1.5 * std::abs(steady.Y[k]) * draws.normal());
    state.velocity.push_back(1.5 * std::abs(steady.Y[k]) * omega * draws.normal());
  }
  return state;
}

// From rest, from any state, or after a change of a drive before.
void draw_motion(Draws& draws, Case& about, const TableMotion& table) {
  about.motion = std::make_shared<Motion>(about.chain, about.sensors);
  const double kind = draws.uniform(0, 1);
  if (kind < 0.35) {
    about.motion->drive(0.0, table);
    about.remark += "from rest";
  } else if (kind < 0.7) {
    about.motion->drive(0.0, table, draw_state(draws, about.chain, table));
    about.remark += "from any state";
  } else {
    TableMotion before = table;
    const double factor = draws.chance(0.5) ? draws.log_uniform(0.3, 0.8) : draws.log_uniform(1.25, 3);
    for (Complex& shape : before.shape) shape *= factor;
    if (about.rig.excitation.reference == Reference::tracked && draws.chance(0.5))
      before.frequency_hz = std::clamp(before.frequency_hz * (1 + draws.sign() * draws.uniform(0.015, 0.03)),
                                       about.rig.excitation.search_low_hz, about.rig.excitation.search_high_hz);
    const int periods = draws.integer(8, 40);
    about.change_s = periods / before.frequency_hz;
    if (draws.chance(0.5))
      about.motion->drive(0.0, before);
    else
      about.motion->drive(0.0, before, about.motion->steady_state(before));
    about.motion->drive(about.change_s, table);
    about.remark += "after a change";
  }
  // A free decay in one channel alone: its own bracket rings, no longer than the rig's slowest mode.
  if (draws.chance(0.1)) {
    const int c = draws.integer(1, about.channels() - 1);
    const double tau_s = about.motion->time_constant_s() * draws.uniform(0.3, 1);
    const double omega = kTwoPi * about.frequency_hz * draws.log_uniform(0.2, 4);
    about.motion->ring(
        c, std::abs(about.motion->phasor(c, 1)) * std::polar(draws.log_uniform(0.05, 2), draws.uniform(0, kTwoPi)),
        {-1 / tau_s, omega});
    about.remark += ", one channel rings";
  }
}

void draw_sampling(Draws& draws, Case& about) {
  const double periods = 60 + 8 * about.motion->time_constant_s() * about.frequency_hz + about.hold_periods;
  const double most = std::clamp(kMostSamples / (periods * about.channels()), 12.0, 200.0);
  const double common = std::min(most, draws.log_uniform(10, 200));
  const bool same = draws.chance(0.7);
  const double skew = draws.chance(0.8) ? draws.uniform(0, 1.0 / about.channels()) : 0.0;
  const double jitter = draws.chance(0.7) ? draws.uniform(0, 0.5) : 0.0;
  const double start = draws.uniform(0, 1);
  for (int c = 0; c < about.channels(); ++c) {
    Line& line = about.lines[static_cast<std::size_t>(c)];
    line.rate_hz = about.frequency_hz * (same ? common : std::min(most, draws.log_uniform(10, 200)));
    line.phase = start + c * skew;
    line.jitter = jitter;
  }
}

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

void draw_noise(Draws& draws, Case& about, double table_amplitude) {
  const double common = draws.log_uniform(2e-4, 2e-2);
  for (int c = 0; c < about.channels(); ++c) {
    Line& line = about.lines[static_cast<std::size_t>(c)];
    const double scale = scale_of_noise(about, c, table_amplitude);
    line.sigma = scale * std::clamp(common * draws.log_uniform(0.5, 2), 2e-4, 2e-2);
    line.mean = scale * draws.uniform(-1, 1);
    const bool all = about.population == Population::steady;
    if (about.population == Population::hum || (all && draws.chance(0.5))) {
      line.hum = scale * draws.log_uniform(5e-4, 2e-2);
      line.hum_hz = 50 + draws.uniform(-0.05, 0.05);
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

void draw_drive_settings(Draws& draws, Case& about, double from_nominal) {
  Excitation& excitation = about.rig.excitation;
  excitation.reference = from_nominal != 0 ? Reference::tracked : Reference::fixed;
  excitation.frequency_hz = about.frequency_hz / (1 + from_nominal);
  excitation.search_low_hz = 0.98 * excitation.frequency_hz;
  excitation.search_high_hz = 1.02 * excitation.frequency_hz;
  excitation.clock_u = 0.0;
  excitation.harmonics = draws.integer(1, 3);
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
    about.half_ns.push_back(static_cast<std::uint32_t>(std::llround(1e9 * half_s[device])));
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

}  // namespace

double Case::threshold(int c) const {
  return std::max(rig.tolerance * std::abs(motion->phasor(c, 1)),
                  3 * lines[static_cast<std::size_t>(c)].noise() * std::sqrt(2 / (10 * samples_per_period(c))));
}

Case draw(Population population, std::uint64_t seed, int index) {
  Case about;
  about.population = population;
  about.index = index;
  about.seed =
      mixed(mixed(seed) ^ mixed((static_cast<std::uint64_t>(population) << 40) + static_cast<std::uint64_t>(index)));
  Draws draws(about.seed);
  about.frequency_hz = draws.log_uniform(2, 40);
  DrawnChain drawn = draw_chain(draws, about.frequency_hz);
  about.chain = std::move(drawn.chain);
  about.remark = drawn.remark;
  about.rig.name = "study";
  about.rig.boundary = about.chain.boundary;
  about.rig.masses = about.chain.masses;
  about.rig.tolerance = draws.chance(0.3) ? draws.log_uniform(0.002, 0.02) : 0.005;
  const double off = population == Population::tracked                       ? 0.01 * draws.sign()
                     : population == Population::white                       ? 0.0
                     : population == Population::type_b || draws.chance(0.5) ? draws.uniform(-0.019, 0.019)
                                                                             : 0.0;
  draw_drive_settings(draws, about, off);
  draw_channels(draws, about);
  about.lines.resize(about.sensors.size());
  about.half_ns.clear();
  about.hold_periods = population == Population::white || population == Population::tracked
                           ? draws.uniform(50, 100)
                           : draws.log_uniform(10, 100);
  if (population == Population::type_b) draw_type_b(draws, about);
  about.half_ns.resize(about.sensors.size());
  const TableMotion table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.rig.excitation.minimum = 1e-3 * std::abs(table.shape[0]);
  draw_motion(draws, about, table);
  draw_sampling(draws, about);
  draw_noise(draws, about, std::abs(table.shape[0]));
  for (int c = 0; c < about.channels(); ++c)
    about.motion->prune(c, 1e-4 * about.lines[static_cast<std::size_t>(c)].noise());
  return about;
}

const char* name_of(Population population) {
  switch (population) {
    case Population::white:
      return "white";
    case Population::tracked:
      return "tracked";
    case Population::hum:
      return "hum";
    case Population::type_b:
      return "type_b";
    case Population::quantized:
      return "quantized";
    case Population::coarse:
      return "coarse";
    case Population::stiff:
      return "stiff";
    case Population::amplitude_step:
      return "amplitude_step";
    case Population::frequency_step:
      return "frequency_step";
    case Population::small_step:
      return "small_step";
    case Population::stop:
      return "stop";
    case Population::steady:
      return "steady";
    case Population::ramps:
      return "ramps";
  }
  return "";
}

std::string Case::description() const {
  double most = 0.0, fewest = INFINITY, noise = 0.0;
  for (int c = 0; c < channels(); ++c) {
    most = std::max(most, samples_per_period(c));
    fewest = std::min(fewest, samples_per_period(c));
    noise = std::max(noise, lines[static_cast<std::size_t>(c)].noise() / std::abs(motion->phasor(c, 1)));
  }
  char text[256];
  std::snprintf(text, sizeof text,
                "n=%d %s f=%.2f Hz (%s) H=%d tau=%.1f periods, %.0f…%.0f samples a period, noise up to %.2g, tolerance "
                "%.3g, ",
                chain.mass_count(), chain.boundary == Boundary::clamped ? "clamped" : "free", frequency_hz,
                rig.excitation.reference == Reference::fixed ? "fixed" : "tracked", rig.excitation.harmonics,
                motion->time_constant_s() * frequency_hz, fewest, most, noise, rig.tolerance);
  return text + remark;
}

}  // namespace dwell::study
