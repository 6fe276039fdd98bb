#include "tests/study/fault.hpp"

#include <cmath>
#include <iterator>

#include "core/base/angle.hpp"
#include "tests/study/signal.hpp"

namespace dwell::study {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kMostReadings = 20'000;
constexpr double kSettled = 6.0;  // time constants after which little is left that tells more than the steady motion
constexpr double kStep = 1e-4;    // part of a fault over which it is taken as linear

double until_s(const Case& about) {
  return about.change_s + kSettled * about.motion->time_constant_s() + about.hold_periods * about.period_s();
}

// What `put` makes of the readings, per one of what it is given.
template <class Put>
double stands_out(const Case& about, double size, double step, const Put& put) {
  const std::vector<ReadingAt> readings = readings_at(about, about.change_s, until_s(about), kMostReadings);
  const World truth = world_of(about);
  World moved = truth;
  put(moved, step);
  const VectorXd column = (signal(moved, readings) - signal(truth, readings)) / step;
  return std::abs(size) * left_of(column, derivatives(truth, readings, false));
}

double put_mass(Draws& draws, Case& about) {
  const auto k = static_cast<std::size_t>(draws.integer(1, about.chain.mass_count()) - 1);
  const double off = draws.sign() * draws.log_uniform(0.05, 0.5);
  const double out = stands_out(about, off, kStep, [k](World& w, double by) { w.chain.masses[k] *= 1 + by; });
  about.rig.masses[k] *= 1 + off;
  return out;
}

double put_scale(Draws& draws, Case& about) {
  const auto c = static_cast<std::size_t>(draws.integer(0, about.channels() - 1));
  const double off = draws.sign() * draws.log_uniform(0.02, 0.3);
  const double out = stands_out(about, off, kStep, [c](World& w, double by) { w.sensors[c].gain *= 1 + by; });
  about.rig.channels[c].scale *= 1 + off;
  return out;
}

double put_delay(Draws& draws, Case& about) {
  const auto c = static_cast<std::size_t>(draws.integer(0, about.channels() - 1));
  const double late_s = draws.sign() * draws.log_uniform(0.002, 0.05) * about.period_s();
  const double out =
      stands_out(about, late_s, kStep * about.period_s(), [c](World& w, double by) { w.sensors[c].delay_s += by; });
  about.rig.channels[c].delay_s += late_s;
  return out;
}

double put_to_ground(Fault fault, Draws& draws, Case& about) {
  SideSpring spring;
  spring.mass = draws.integer(1, about.chain.mass_count());
  const double c = about.chain.stiffness[static_cast<std::size_t>(spring.mass - 1)];
  const bool damper = fault == Fault::ground_damper;
  double& size = damper ? spring.damping : spring.stiffness;
  size = c * draws.log_uniform(0.005, 0.5) / (damper ? kTwoPi * about.frequency_hz : 1.0);
  const double out = stands_out(about, 1.0, kStep, [&spring](World& w, double by) {
    SideSpring part = spring;
    part.stiffness *= by;
    part.damping *= by;
    w.side.push_back(part);
  });
  const World truth = world_of(about);
  about.side.push_back(spring);
  about.motion = std::make_shared<Motion>(about.chain, about.sensors, about.side);
  about.motion->drive(about.change_s, about.table, truth.state);
  return out;
}

double put_nonlinear(Fault fault, Draws& draws, Case& about) {
  const int k = draws.integer(1, about.chain.element_count());
  const auto e = static_cast<std::size_t>(k - 1), n = static_cast<std::size_t>(about.chain.mass_count());
  const std::vector<Complex> Y = about.motion->respond(kTwoPi * about.frequency_hz, about.table.shape[0]);
  const double d = std::abs(e == n ? Y[n] : Y[e + 1] - Y[e]), c = about.chain.stiffness[e];
  Course::Nonlinear term;
  term.element = k;
  if (fault == Fault::friction)
    term.friction = draws.log_uniform(3e-3, 0.2) * c * d;
  else
    term.cubic = draws.sign() * draws.log_uniform(3e-3, 0.2) * c / (d * d);
  const double end_s = until_s(about) + 60 * about.period_s() + 2 * about.motion->time_constant_s();
  about.course = std::make_shared<Course>(about.chain, about.sensors, term, about.table, end_s);
  const std::vector<ReadingAt> readings = readings_at(about, about.change_s, until_s(about), kMostReadings);
  const World truth = world_of(about);
  VectorXd column = -signal(truth, readings);
  for (std::size_t i = 0; i < readings.size(); ++i)
    column(static_cast<Index>(i)) += readings[i].weight * about.course->reading(readings[i].channel, readings[i].t_s);
  return column.allFinite() ? left_of(column, derivatives(truth, readings, false)) : 0.0;
}

}  // namespace

const char* name_of(Fault fault) {
  constexpr const char* names[] = {"mass", "scale", "delay", "cubic", "friction", "ground damper", "ground spring"};
  static_assert(std::size(names) == kFaults);
  return names[static_cast<int>(fault)];
}

double put_fault(Fault fault, Draws& draws, Case& about) {
  switch (fault) {
    case Fault::mass:
      return put_mass(draws, about);
    case Fault::scale:
      return put_scale(draws, about);
    case Fault::delay:
      return put_delay(draws, about);
    case Fault::cubic:
    case Fault::friction:
      return put_nonlinear(fault, draws, about);
    case Fault::ground_damper:
    case Fault::ground_spring:
      return put_to_ground(fault, draws, about);
  }
  return 0.0;
}

}  // namespace dwell::study
