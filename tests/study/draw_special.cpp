#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/study/bound.hpp"
#include "tests/study/draw_parts.hpp"

namespace dwell::study {
namespace {

constexpr double kSlowest = 40.0;  // periods: time constant of a rig that is to be measured soon

void begin_steady(Case& about) {
  about.motion = std::make_shared<Motion>(about.chain, about.sensors);
  about.motion->drive(0.0, about.table, about.motion->steady_state(about.table));
}

// A rig in its steady motion, the drive as given or tracked.
void draw_steady_rig(Draws& draws, Case& about, double slowest_hz, double fastest_hz, int most_masses) {
  about.frequency_hz = draws.log_uniform(slowest_hz, fastest_hz);
  do {
    draw_chain(draws, about, most_masses);
  } while (Motion(about.chain, {}).time_constant_s() * about.frequency_hz > kSlowest);
  draw_drive_settings(draws, about, draws.chance(0.5) ? draws.uniform(-0.01, 0.01) : 0.0);
  draw_channels(draws, about);
  about.table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.rig.excitation.minimum = 1e-2 * std::abs(about.table.shape[0]);
  begin_steady(about);
}

}  // namespace

void draw_stiff(Draws& draws, Case& about) {
  draw_steady_rig(draws, about, 2, 40, 4);
  about.rig.excitation.reference = Reference::fixed;
  about.rig.excitation.frequency_hz = about.frequency_hz;
  about.hold_periods = draws.log_uniform(10, 40);
  const auto e = static_cast<std::size_t>(draws.integer(0, about.chain.element_count() - 1));
  // |d| over its standard deviation: most below one, some where it ought to be reported.
  const double wanted = draws.chance(0.7) ? draws.log_uniform(0.02, 0.99) : draws.log_uniform(1, 30);
  draw_sampling(draws, about, 10, 60);
  const Draws before = draws;
  for (int step = 0; step < 12; ++step) {
    begin_steady(about);
    draws = before;
    draw_noise(draws, about, std::abs(about.table.shape[0]));
    const ElementBound bound = bounds_of(about, about.hold_periods * about.period_s())[e];
    const double more = std::abs(bound.d) / bound.sigma_d / wanted;
    if (std::abs(more - 1) < 0.02 || (step == 0 && more < 1)) break;
    about.chain.stiffness[e] *= more;
    about.chain.damping[e] *= std::sqrt(more);  // its damping ratio stays
  }
  about.remark += "element " + std::to_string(e + 1) + " stiff";
}

void draw_step(Draws& draws, Case& about) {
  draw_steady_rig(draws, about, 2, 40, 3);
  const bool is_small = about.population == Population::small_step;
  draw_sampling(draws, about, 10, is_small ? 25 : 100);
  draw_noise(draws, about, std::abs(about.table.shape[0]));
  const double tolerance = about.rig.tolerance, amplitude = std::abs(about.table.shape[0]);
  const double samples = about.samples_per_period(0);
  Line& table = about.lines[0];
  about.after = about.table;
  about.limit_periods = 2;
  double size = 0.0;
  switch (about.population) {
    case Population::amplitude_step:
      size = std::max(3 * tolerance, 9 * table.sigma / amplitude * std::sqrt(2 / (2 * samples))) *
             draws.log_uniform(1.0001, 4);
      break;
    case Population::small_step:
      // Not seen within two periods for the noise there is, which is up to 2 %.
      size = 3 * tolerance * draws.log_uniform(1.0001, 1.5);
      about.limit_periods = std::min(draws.log_uniform(2.2, 25), std::pow(0.02 * 9 / size, 2) * 2 / samples);
      table.sigma = amplitude * size / 9 * std::sqrt(about.limit_periods * samples / 2);
      break;
    case Population::frequency_step:
      about.after.frequency_hz *= 1 + draws.sign() * 3 * tolerance * draws.log_uniform(1.0001, 3);
      break;
    default:  // it stops
      size = -1;
      about.limit_periods = 3;
  }
  if (size > 0 && size < 0.9) size *= draws.sign();
  for (Complex& shape : about.after.shape) shape *= 1 + size;
  about.hold_periods = draws.uniform(10, 60) + 3 * about.limit_periods;
  about.remark +=
      about.population == Population::frequency_step
          ? "then a step of frequency by " + std::to_string(about.after.frequency_hz / about.frequency_hz - 1)
          : "then a step of amplitude by " + std::to_string(size);
}

void draw_hours(Draws& draws, Case& about) {
  about.hours = 0.25;
  about.remark = "steady ";
  const bool costly = draws.chance(0.05);
  draw_steady_rig(draws, about, 2, costly ? 40 : 5, costly ? 4 : 2);
  about.hold_periods = about.hours * 3600 * about.frequency_hz;
  about.rig.memory_s = draws.log_uniform(30, 600);
  draw_sampling(draws, about, 10, costly ? 100 : 16);
  draw_noise(draws, about, std::abs(about.table.shape[0]));
  if (draws.chance(0.5)) about.glitches = draws.log_uniform(1e-5, 1e-3);
  if (draws.chance(0.5)) about.lost = draws.log_uniform(1e-4, 1e-2);
}

void draw_ramps(Draws& draws, Case& about) {
  about.frequency_hz = draws.log_uniform(2, 40);
  about.chain = {Boundary::clamped, {}, {draws.log_uniform(1e4, 1e6)}, {}};
  const double omega = 2 * std::numbers::pi * about.frequency_hz;
  about.chain.damping.push_back(about.chain.stiffness[0] / omega * draws.log_uniform(0.03, 1.5));
  about.rig.boundary = Boundary::clamped;
  draw_drive_settings(draws, about, draws.uniform(-0.01, 0.01));
  about.rig.tolerance = draws.log_uniform(0.005, 0.05);
  draw_channels(draws, about);
  about.table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.table.shape[0] = std::polar(std::abs(about.table.shape[0]), draws.uniform(0, 2 * std::numbers::pi));
  about.rig.excitation.minimum = 0.04 * std::abs(about.table.shape[0]);
  begin_steady(about);
  draw_sampling(draws, about, 10, 200);
  draw_noise(draws, about, std::abs(about.table.shape[0]));
  Ramps& ramps = about.ramps;
  ramps.rise_s = draws.uniform(0, 3) / about.frequency_hz;
  ramps.hold_s = ramps.rise_s + draws.uniform(1.5, 3) / about.frequency_hz;
  ramps.fall_s = ramps.hold_s + 3 / about.frequency_hz;
  ramps.end_s = ramps.fall_s + draws.uniform(1.5, 3) / about.frequency_hz;
  about.remark = "ramps";
}

}  // namespace dwell::study
