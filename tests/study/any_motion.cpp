#include "tests/study/any_motion.hpp"

#include <cmath>

#include "core/base/angle.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "tests/study/cpu_time.hpp"
#include "tests/study/draw_parts.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

// The tones of a table that moves so, the fundamental left out.
std::vector<Tone> tones_of(Draws& draws, TableKind kind, double f, Complex A) {
  std::vector<Tone> tones;
  if (kind == TableKind::ramp) {  // A sin(ωt) sin²(πt/T) = its side bands
    const double T = draws.uniform(8, 40) / f;
    tones.push_back({f, -0.5 * A});
    tones.push_back({f + 1 / T, -0.25 * A});
    tones.push_back({f - 1 / T, -0.25 * A});
  } else if (kind == TableKind::random) {
    tones.push_back({f, -A});
    for (int i = 0; i < 40; ++i)
      tones.push_back({f * draws.log_uniform(0.2, 2.5),
                       std::abs(A) * std::sqrt(1.0 / 40) * std::polar(1.0, draws.uniform(0, kTwoPi))});
  } else if (kind == TableKind::wander) {
    for (int i = 0; i < 6; ++i)
      tones.push_back({f * (1 + draws.sign() * draws.log_uniform(0.01, 0.2)),
                       0.1 * std::abs(A) / std::sqrt(3.0) * std::polar(1.0, draws.uniform(0, kTwoPi))});
  }
  return tones;
}

// What the table does between few readings hardly shows, so that noise and the table's process may be taken for each
// other.
TableMotion sparse_table(Draws& draws, double f) {
  const Complex A{draws.log_uniform(2e-4, 5e-3), 0.0};
  TableMotion table{f, {A}};
  switch (draws.integer(0, 3)) {
    case 0:
      break;
    case 1:
      table.tones.push_back({f * draws.uniform(1.3, 2.0), 0.4 * A});
      break;
    case 2:  // A sin(ωt) sin²(πt/T), T twenty periods
      table.tones = {{f, -0.5 * A}, {f * (1 + 1 / 20.0), -0.25 * A}, {f * (1 - 1 / 20.0), -0.25 * A}};
      break;
    default:
      table.tones.push_back({f, -A});
      for (int i = 0; i < 8; ++i)
        table.tones.push_back({f * draws.log_uniform(0.3, 1.8), draws.uniform(0.15, 0.65) * A});
  }
  return table;
}

Case draw_sparse(std::uint64_t seed, int index, int most) {
  Case about;
  about.index = index;
  about.seed = mixed(mixed(seed) ^ mixed((std::uint64_t{1} << 50) + static_cast<std::uint64_t>(index)));
  Draws draws(about.seed);
  about.rig.name = "study";
  about.frequency_hz = draws.log_uniform(2, 40);
  if (most > 0 && draws.chance(0.6)) {
    draw_chain(draws, about, 1);
  } else {
    const double c = draws.log_uniform(1e4, 1e5);
    about.chain = {Boundary::clamped, {}, {c}, {c * draws.uniform(0.02, 0.22) / (kTwoPi * about.frequency_hz)}};
    about.rig.boundary = about.chain.boundary;
  }
  draw_drive_settings(draws, about, 0.0);
  draw_channels(draws, about);
  about.table = sparse_table(draws, about.frequency_hz);
  about.rig.excitation.minimum = 1e-3 * std::abs(about.table.shape[0]);
  about.motion = std::make_shared<Motion>(about.chain, about.sensors);
  about.motion->drive(0.0, about.table);
  const double rate_hz = about.frequency_hz * draws.uniform(5, 14), noise = draws.uniform(0.01, 0.02);
  const double jitter = draws.chance(0.4) ? 0.6 : 0.0, skew = draws.chance(0.5) ? 0.3 : 0.0;
  for (int c = 0; c < about.channels(); ++c) {
    Line& line = about.lines[static_cast<std::size_t>(c)];
    line.rate_hz = rate_hz;
    line.jitter = jitter;
    line.phase = skew * c / about.channels();
    line.sigma = noise * std::abs(about.motion->phasor(c, 1));
  }
  return about;
}

}  // namespace

MotionRecorder recorded(const Case& about, double until_s) {
  MotionRecorder recorder(about.rig);
  Player player(about);
  for (Record record = player.next(); player.now_s() < until_s; record = player.next()) recorder.take(record);
  return recorder;
}

const char* name_of(TableKind kind) {
  constexpr const char* names[kTableKinds] = {"dwell", "ramp", "random", "wander", "sparse"};
  return names[static_cast<int>(kind)];
}

Case draw_motion_case(TableKind kind, std::uint64_t seed, int index, int most) {
  if (kind == TableKind::sparse) return draw_sparse(seed, index, most);
  for (std::uint64_t again = 0;; ++again) {
    Case about = draw(Population::white, seed + 1000 * again, index);
    if (about.chain.mass_count() > most) continue;
    if (kind == TableKind::dwell) return about;
    Draws draws(mixed(about.seed) ^ static_cast<std::uint64_t>(kind));
    about.change_s = 0.0;
    about.table.tones = tones_of(draws, kind, about.frequency_hz, about.table.shape[0]);
    if (kind == TableKind::ramp) about.table.shape.resize(1);
    about.motion = std::make_shared<Motion>(about.chain, about.sensors);
    about.motion->drive(0.0, about.table);
    return about;
  }
}

MotionOutcome play_motion(const Case& about, double periods) {
  MotionOutcome outcome;
  const MotionRecorder recorder = recorded(about, about.change_s + periods / about.frequency_hz);
  const double before = cpu_s();
  const MotionEstimate estimate = estimate_motion(about.rig, recorder.data());
  outcome.seconds = cpu_s() - before;
  outcome.reason = estimate.reason;
  outcome.refused = estimate.reason.find("the chain of the rig file does not explain") != std::string::npos;
  outcome.advised = estimate.missing.empty() ? 0 : 1;
  for (const std::string& warning : estimate.warnings)
    if (warning.find("uncertainties are widened") != std::string::npos) outcome.widened = 1;
  for (std::size_t e = 0; e < estimate.elements.size(); ++e) {
    const ElementEstimate& element = estimate.elements[e];
    if (!element.identifiable) {
      ++outcome.withheld;
      continue;
    }
    for (const auto& [given, truth] :
         {std::pair{element.stiffness, about.chain.stiffness[e]}, std::pair{element.damping, about.chain.damping[e]}}) {
      outcome.errors.push_back((given.value - truth) / given.u);
      outcome.beyond.push_back(std::abs(given.value - truth) / given.U95);
    }
  }
  return outcome;
}

}  // namespace dwell::study
