#include "tests/study/missing_faults.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "core/motion/score_test.hpp"
#include "tests/study/cpu_time.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

// Bounds the time of a rig to some seconds.
constexpr std::size_t kMostOfMotion = 4000;

std::optional<Unknown> term_of(MissingFault fault) {
  switch (fault) {
    case MissingFault::mass:
      return Unknown::mass;
    case MissingFault::scale:
      return Unknown::scale;
    case MissingFault::delay:
      return Unknown::delay;
    case MissingFault::ground_damping:
      return Unknown::ground_damping;
    case MissingFault::ground_stiffness:
      return Unknown::ground_stiffness;
    case MissingFault::friction:
      return Unknown::friction;
    case MissingFault::cubic:
      return Unknown::cubic;
    default:
      return {};
  }
}

// What a rig truly is beside its case.
struct Truth {
  Chain chain;
  std::vector<Sensor> sensors;
  std::vector<SideSpring> side;
  std::optional<Course::Nonlinear> nonlinear;
};

void play(Case& about, const Truth& truth, double end_s) {
  about.chain = truth.chain;
  about.sensors = truth.sensors;
  about.motion = std::make_shared<Motion>(truth.chain, truth.sensors, truth.side);
  about.motion->drive(0.0, about.table);
  if (truth.nonlinear)
    about.course = std::make_shared<Course>(truth.chain, truth.sensors, *truth.nonlinear, about.table, end_s);
}

// A healthy rig that states what it may be off by, and is.
Truth healthy(Draws& draws, Case& about) {
  Truth truth{about.chain, about.sensors, {}, {}};
  for (double& mass : truth.chain.masses) {
    about.rig.mass_u.push_back(0.002 * mass);
    mass += about.rig.mass_u.back() * draws.normal();
  }
  for (std::size_t c = 0; c < truth.sensors.size(); ++c) {
    Channel& channel = about.rig.channels[c];
    channel.scale_u = 0.001;
    channel.delay_u_s = 2e-4 / (2 * M_PI * about.frequency_hz);
    truth.sensors[c].gain *= 1 + channel.scale_u * draws.normal();
    truth.sensors[c].delay_s += channel.delay_u_s * draws.normal();
  }
  return truth;
}

void apply(const Parameter& term, double by, Truth& truth) {
  const auto i = static_cast<std::size_t>(term.index);
  switch (term.what) {
    case Unknown::mass:
      truth.chain.masses[i] += by;
      break;
    case Unknown::scale:
      truth.sensors[i].gain *= 1 + by;
      break;
    case Unknown::delay:
      truth.sensors[i].delay_s += by;
      break;
    case Unknown::ground_damping:
      truth.side.push_back({term.index + 1, kGround, 0.0, by});
      break;
    case Unknown::ground_stiffness:
      truth.side.push_back({term.index + 1, kGround, by, 0.0});
      break;
    case Unknown::friction:
      truth.nonlinear = Course::Nonlinear{term.index + 1, by, 0.0};
      break;
    default:
      truth.nonlinear = Course::Nonlinear{term.index + 1, 0.0, by};
      break;
  }
}

MotionOptions options_of(const Rig& rig) {
  return {.most_work = kMostOfMotion * static_cast<std::size_t>(MotionModel(rig, {}).states())};
}

void exchange(Draws& draws, MissingFault fault, const Rig& rig, MotionData& data, FaultOutcome& out) {
  const int channels = static_cast<int>(rig.channels.size()), a = draws.integer(0, channels - 1);
  const int b = (a + draws.integer(1, channels - 1)) % channels;
  const auto name = [&](int c) { return rig.channels[static_cast<std::size_t>(c)].name; };
  out.truth = fault == MissingFault::reversed ? "sign of " + name(a)
                                              : name(std::min(a, b)) + " and " + name(std::max(a, b)) + " swapped";
  for (MotionReading& reading : data.readings) {
    if (fault == MissingFault::reversed) {
      if (reading.channel == a) reading.value = -reading.value;
    } else if (reading.channel == a || reading.channel == b) {
      reading.channel = reading.channel == a ? b : a;
    }
  }
}

void judge(const MotionEstimate& estimate, double truth, FaultOutcome& out) {
  out.named_some = !estimate.missing.empty();
  out.detected = out.named_some || !estimate.reason.empty();
  out.told = estimate.reason;
  for (const MissingTerm& term : estimate.missing) {
    out.told += " | " + term.told + " gain " + std::to_string(term.gain);
    if (term.what != out.truth) continue;
    out.named = true;
    out.named_first = &term == &estimate.missing.front();
    out.error = (term.value - truth) / term.u;
  }
}

}  // namespace

const char* name_of(MissingFault fault) {
  constexpr const char* names[kMissingFaults] = {
      "none",     "mass",  "scale",    "delay",  "ground_damping", "ground_stiffness",
      "friction", "cubic", "reversed", "swapped"};
  return names[static_cast<int>(fault)];
}

FaultOutcome play_fault(MissingFault fault, std::uint64_t seed, int index, int most, double periods) {
  FaultOutcome out;
  const bool linear = fault != MissingFault::friction && fault != MissingFault::cubic;
  const auto kind = linear ? static_cast<TableKind>(index % kReadOften) : TableKind::dwell;
  Case about = draw_motion_case(kind, seed, index, most);
  about.change_s = 0.0;
  Draws draws(mixed(about.seed) + 77);
  const double end_s = periods / about.frequency_hz;
  Truth truth = healthy(draws, about);
  play(about, truth, end_s);
  MotionData data = recorded(about, end_s).data();
  double value = NAN;
  if (const std::optional<Unknown> what = term_of(fault)) {
    const MotionCourse course = run_course(about.rig, data, kMostOfMotion);
    if (!course.reason.empty()) return out.skipped = "no estimate: " + course.reason, out;
    const ScoreTest test = score_test(about.rig, course);
    std::vector<Eigen::Index> of;
    for (Eigen::Index a = 0; a < test.sizes.size(); ++a)
      if (test.candidates[static_cast<std::size_t>(a)].what == *what) of.push_back(a);
    if (of.empty()) return out.skipped = "has none", out;
    const Eigen::Index a = of[static_cast<std::size_t>(draws.integer(0, static_cast<int>(of.size()) - 1))];
    const Parameter term = test.candidates[static_cast<std::size_t>(a)];
    out.size = draws.uniform(7, 14);
    double by = out.size / std::sqrt(test.information(a, a));
    if (!test.told[static_cast<std::size_t>(a)] || by > 0.3 * test.sizes(a)) return out.skipped = "cannot tell it", out;
    if (*what == Unknown::mass || *what == Unknown::scale || *what == Unknown::delay) by *= draws.sign();
    out.truth = name_of(about.rig, term);
    apply(term, by, truth);
    play(about, truth, end_s);
    data = recorded(about, end_s).data();
    const auto i = static_cast<std::size_t>(term.index);
    value = *what == Unknown::mass    ? truth.chain.masses[i]
            : *what == Unknown::scale ? 1 / truth.sensors[i].gain
            : *what == Unknown::delay ? truth.sensors[i].delay_s
                                      : by;
  } else if (fault != MissingFault::none) {
    exchange(draws, fault, about.rig, data, out);
  }
  const double before = cpu_s();
  const MotionEstimate estimate = estimate_motion(about.rig, data, options_of(about.rig));
  out.seconds = cpu_s() - before;
  judge(estimate, value, out);
  return out;
}

}  // namespace dwell::study
