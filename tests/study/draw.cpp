#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/study/case.hpp"
#include "tests/study/draw_parts.hpp"

namespace dwell::study {
namespace {

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

// One that begins with a transient, settles and is measured.
void draw_begun(Draws& draws, Case& about) {
  const Population population = about.population;
  const bool timed = population == Population::white || population == Population::tracked;
  about.frequency_hz = draws.log_uniform(2, 40);
  draw_chain(draws, about);
  about.rig.tolerance = draws.chance(0.3) ? draws.log_uniform(0.002, 0.02) : 0.005;
  const double off = population == Population::tracked                       ? 0.01 * draws.sign()
                     : population == Population::white                       ? 0.0
                     : population == Population::type_b || draws.chance(0.5) ? draws.uniform(-0.019, 0.019)
                                                                             : 0.0;
  draw_drive_settings(draws, about, off);
  draw_channels(draws, about);
  about.hold_periods = timed ? draws.uniform(50, 100) : draws.log_uniform(10, 100);
  if (population == Population::type_b) draw_type_b(draws, about);
  about.table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.rig.excitation.minimum = 1e-3 * std::abs(about.table.shape[0]);
  draw_motion(draws, about, about.table);
  draw_sampling(draws, about, 10, 200);
  draw_noise(draws, about, std::abs(about.table.shape[0]));
}

}  // namespace

void draw_motion(Draws& draws, Case& about, const TableMotion& table) {
  about.motion = std::make_shared<Motion>(about.chain, about.sensors, about.side);
  const double kind = draws.uniform(0, 1);
  if (kind < 0.35) {
    about.motion->drive(0.0, table);
    about.remark += "from rest";
  } else if (kind < 0.7) {
    about.motion->drive(0.0, table, draw_state(draws, about.chain, table));
    about.remark += "from any state";
  } else {
    TableMotion before = table;
    before.tones.clear();
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
  if (about.population != Population::disturbed && draws.chance(0.1)) {
    const int c = draws.integer(1, about.channels() - 1);
    const double tau_s = about.motion->time_constant_s() * draws.uniform(0.3, 1);
    const double omega = kTwoPi * about.frequency_hz * draws.log_uniform(0.2, 4);
    about.motion->ring(
        c, std::abs(about.motion->phasor(c, 1)) * std::polar(draws.log_uniform(0.05, 2), draws.uniform(0, kTwoPi)),
        {-1 / tau_s, omega});
    about.remark += ", one channel rings";
  }
}

TableMotion draw_table(Draws& draws, double frequency_hz, int harmonics) {
  TableMotion table{frequency_hz, {Complex{draws.log_uniform(2e-4, 5e-3), 0.0}}};
  if (draws.chance(0.5))
    for (int h = 2; h <= harmonics; ++h)
      table.shape.push_back(table.shape[0] * std::polar(draws.log_uniform(0.001, 0.05), draws.uniform(0, kTwoPi)));
  return table;
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

Case draw(Population population, std::uint64_t seed, int index) {
  Case about;
  about.population = population;
  about.index = index;
  about.seed =
      mixed(mixed(seed) ^ mixed((static_cast<std::uint64_t>(population) << 40) + static_cast<std::uint64_t>(index)));
  Draws draws(about.seed);
  about.rig.name = "study";
  switch (population) {
    case Population::stiff:
      draw_stiff(draws, about);
      break;
    case Population::amplitude_step:
    case Population::frequency_step:
    case Population::small_step:
    case Population::stop:
      draw_step(draws, about);
      break;
    case Population::steady:
      draw_hours(draws, about);
      break;
    case Population::ramps:
      draw_ramps(draws, about);
      break;
    case Population::resonance:
      draw_resonance(draws, about);
      break;
    case Population::knocks:
      draw_knocks(draws, about);
      break;
    case Population::disturbed:
      draw_disturbed(draws, about);
      break;
    default:
      draw_begun(draws, about);
  }
  for (int c = 0; c < about.channels(); ++c)
    about.motion->prune(c, 1e-4 * about.lines[static_cast<std::size_t>(c)].noise());
  return about;
}

}  // namespace dwell::study
