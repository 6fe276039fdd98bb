// A rig that is knocked while it settles: someone works on the table, or the next machine runs.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/study/draw_parts.hpp"

namespace dwell::study {
namespace {

constexpr double kSoonest_s = 5.0, kSeldomest_s = 60.0;     // mean time between knocks, but
constexpr double kMostDecay = 400.0;                        // periods, of the slowest decay time
constexpr double kMean = 0.5, kLongest = 1.0;               // … of the slowest decay time at most: it must not settle
constexpr double kShortest_s = 12.0, kLongest_s = 600.0;    // for so long it is knocked …
constexpr double kMostPeriods = 3000.0, kMostKnocks = 200;  // … at most, for the study to take no hours
constexpr double kGentlest = 0.1, kHardest = 3.0;           // of the steady motion of the mass that is knocked
constexpr double kFewestAPeriod = 10.0, kMostAPeriod = 30.0;  // a period

}  // namespace

void draw_knocks(Draws& draws, Case& about) {
  about.frequency_hz = draws.log_uniform(2, 40);
  // Between knocks every 5 … 60 s it must not settle.
  double tau_s = 0.0;
  while (!(tau_s > kSoonest_s && tau_s * about.frequency_hz < kMostDecay)) {
    about.remark.clear();
    draw_chain(draws, about, 4);
    tau_s = Motion(about.chain, {}).time_constant_s();
  }
  about.rig.tolerance = draws.chance(0.3) ? draws.log_uniform(0.002, 0.02) : 0.005;
  draw_drive_settings(draws, about, draws.chance(0.5) ? draws.uniform(-0.019, 0.019) : 0.0);
  draw_channels(draws, about);
  about.hold_periods = draws.log_uniform(10, 50);
  about.table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.rig.excitation.minimum = 1e-3 * std::abs(about.table.shape[0]);
  about.motion = std::make_shared<Motion>(about.chain, about.sensors);
  about.motion->drive(0.0, about.table);
  const double omega = kTwoPi * about.frequency_hz;
  const SteadyResponse steady = steady_response(about.chain, omega, about.table.shape[0]);
  const double mean_s = std::min(draws.log_uniform(kSoonest_s, kSeldomest_s), kMean * tau_s);
  const double last_s = std::min(draws.log_uniform(kShortest_s, kLongest_s), kMostPeriods / about.frequency_hz);
  double t_s = 0.0;
  int knocks = 0;
  while (t_s < last_s && knocks < kMostKnocks) {
    t_s += std::clamp(-mean_s * std::log(draws.uniform(1e-9, 1)), 1e-3, kLongest * tau_s);
    const int mass = draws.integer(1, about.chain.mass_count());
    const double velocity = omega * std::abs(steady.Y[static_cast<std::size_t>(mass)]);
    about.motion->knock(t_s, mass, draws.sign() * draws.log_uniform(kGentlest, kHardest) * velocity);
    ++knocks;
  }
  about.change_s = t_s;
  about.remark += "from rest, " + std::to_string(knocks) + " knocks in " + std::to_string(std::lround(t_s)) + " s";
  draw_sampling(draws, about, kFewestAPeriod, kMostAPeriod);
  draw_noise(draws, about, std::abs(about.table.shape[0]));
}

}  // namespace dwell::study
