// The drive at a natural frequency: a mode and the steady motion that grow apart only as slowly as the mode decays.
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/study/draw_parts.hpp"

namespace dwell::study {
namespace {

constexpr double kLightestDriven = 0.002, kHeaviestDriven = 0.01;  // damping ratio of the mode that is driven
constexpr double kQuiet = 2e-4, kNoisy = 2e-2;                     // noise, of each channel's own amplitude

double damping_of(Complex pole) { return -pole.real() / std::abs(pole); }

// A chain of which one mode has the damping ratio `wanted`, and which one.
Complex draw_mode(Draws& draws, Case& about, double wanted) {
  const int n = draws.integer(1, 3);
  for (;;) {
    Chain chain{draws.chance(0.5) ? Boundary::clamped : Boundary::free, {}, {}, {}};
    for (int k = 0; k < n; ++k) chain.masses.push_back(draws.log_uniform(3, 30));
    for (int e = 0; e < chain.element_count(); ++e) {
      chain.stiffness.push_back(1e4 * draws.log_uniform(0.3, 3));
      chain.damping.push_back(chain.stiffness.back() * draws.log_uniform(0.5, 2) * 1e-6);
    }
    const auto one_of = [&](std::size_t i) {
      std::vector<Complex> modes;
      for (const Complex& pole : natural_values(chain))
        if (pole.imag() > 0) modes.push_back(pole);
      std::sort(modes.begin(), modes.end(), [](Complex a, Complex b) { return a.imag() < b.imag(); });
      return i < modes.size() ? modes[i] : Complex{};
    };
    const auto which = static_cast<std::size_t>(draws.integer(0, n - 1));
    const double more = wanted / damping_of(one_of(which));
    for (double& r : chain.damping) r *= more;
    const Complex pole = one_of(which);
    if (std::abs(damping_of(pole) / wanted - 1) > 0.1) continue;
    about.chain = chain;
    return pole;
  }
}

}  // namespace

void draw_resonance(Draws& draws, Case& about) {
  about.frequency_hz = draws.log_uniform(2, 40);
  const double wanted = draws.log_uniform(kLightestDriven, kHeaviestDriven);
  const Complex pole = draw_mode(draws, about, wanted);
  Chain& chain = about.chain;
  // Within the half-power width, ± ζ of the natural frequency.
  const double drive = std::abs(pole) * (1 + draws.uniform(-1, 1) * wanted);
  const double faster = kTwoPi * about.frequency_hz / drive;
  for (double& c : chain.stiffness) c *= faster * faster;
  for (double& r : chain.damping) r *= faster;
  about.rig.boundary = chain.boundary;
  about.rig.masses = chain.masses;
  draw_drive_settings(draws, about, draws.chance(0.5) ? draws.uniform(-0.019, 0.019) : 0.0);
  draw_channels(draws, about);
  about.hold_periods = draws.log_uniform(20, 100);
  about.table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.rig.excitation.minimum = 1e-3 * std::abs(about.table.shape[0]);
  about.motion = std::make_shared<Motion>(chain, about.sensors);
  about.remark = "resonance ";
  if (draws.chance(0.5)) {
    about.motion->drive(0.0, about.table);
    about.remark += "from rest";
  } else {
    TableMotion before = about.table;
    const double factor = draws.chance(0.5) ? draws.log_uniform(0.3, 0.8) : draws.log_uniform(1.25, 3);
    for (Complex& shape : before.shape) shape *= factor;
    about.change_s = draws.integer(8, 40) / before.frequency_hz;
    about.motion->drive(0.0, before, about.motion->steady_state(before));
    about.motion->drive(about.change_s, about.table);
    about.remark += "after a change";
  }
  draw_sampling(draws, about, 10, 60);
  const double noise = draws.log_uniform(kQuiet, kNoisy);
  for (int c = 0; c < about.channels(); ++c) {
    Line& line = about.lines[static_cast<std::size_t>(c)];
    const double amplitude = std::abs(about.motion->phasor(c, 1));
    line.sigma = noise * amplitude;
    line.mean = amplitude * draws.uniform(-1, 1);
  }
}

}  // namespace dwell::study
