#include "core/motion/refit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/motion/element_inputs.hpp"
#include "core/motion/whiteness.hpp"

namespace dwell {
namespace {

using Eigen::Index;

// Two kinds of terms are fitted in rounds. An input depends on the fitted motion, at first on the one without it: it is
// computed anew from each fit. Of a delay the model has the first terms of a series: the stamps are shifted by what was
// found. The rounds end when the gain grows by less than this part, after kRounds at the latest.
constexpr double kSettled = 0.01;
constexpr int kRounds = 6;
// rad of the drive: up to here the model's three terms of a delay are exact to 10⁻⁶ of the motion.
constexpr double kExact = 0.07;

// V with the priors' part.
double value_at(const MotionModel& model, const MotionData& data, const MotionUnknowns& at) {
  double V = evaluate(model, data, at, {.derivatives = false}).V;
  for (Index a = 0; a < at.theta.size(); ++a)
    if (const double u = model.parameters()[static_cast<std::size_t>(a)].prior_u; u > 0)
      V += 0.5 * at.theta(a) * at.theta(a) / (u * u);
  return V;
}

}  // namespace

MotionData shifted(MotionData data, int channel, double by_s) {
  for (MotionReading& reading : data.readings)
    if (reading.channel == channel) reading.t_ns += to_ns(by_s);
  std::stable_sort(data.readings.begin(), data.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  return data;
}

Refit refit_with(const Rig& rig, const MotionCourse& course, const Parameter& term, const MotionUnknowns& start,
                 double value) {
  std::vector<Parameter> parameters = course.parameters;
  MotionUnknowns at = course.fit.at;
  FitLimits limits = course.limits;
  auto known = std::find_if(parameters.begin(), parameters.end(),
                            [&](const Parameter& p) { return p.what == term.what && p.index == term.index; });
  const auto a = static_cast<Index>(known - parameters.begin());
  if (known != parameters.end()) {
    known->prior_u = 0.0;
  } else {
    parameters.push_back(term);
    at.theta.conservativeResizeLike(Eigen::VectorXd::Zero(a + 1));
    limits.lowest.conservativeResizeLike(Eigen::VectorXd::Constant(a + 1, -1e300));
  }
  if (term.what == Unknown::mass) limits.lowest(a) = lowest_departure(rig.masses[static_cast<std::size_t>(term.index)]);

  const MotionModel model(rig, parameters, course.process);
  MotionData data = course.data;
  MotionFit fit;
  if (is_input(term.what)) data.inputs = element_inputs(course.model(rig), course.data, course.fit.at, {term});
  MotionUnknowns there = start;
  there.theta.conservativeResizeLike(Eigen::VectorXd::Zero(at.theta.size()));
  there.theta(a) = value;
  for (Index i = 0; i < at.theta.size(); ++i) there.theta(i) = std::max(there.theta(i), limits.lowest(i));
  if (value_at(model, data, there) < course.fit.V) at = there;
  double in_stamps = 0.0;  // s: the part of a delay by which the stamps have been shifted
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0 && is_input(term.what)) data.inputs = element_inputs(model, data, at, {term});
    if (round > 0 && term.what == Unknown::delay) {
      data = shifted(std::move(data), term.index, -at.theta(a));
      in_stamps += std::exchange(at.theta(a), 0.0);
    }
    const double gained = course.fit.V - fit.V;
    fit = fit_motion(model, data, at, limits);
    at = fit.at;
    const bool shifts = term.what == Unknown::delay &&
                        (in_stamps != 0.0 || !(std::abs(at.theta(a)) * kTwoPi * rig.excitation.frequency_hz < kExact));
    if (!shifts && (!is_input(term.what) || !fit.converged)) break;
    if (round > 1 && fit.converged && course.fit.V - fit.V < (1 + kSettled) * gained) break;
  }
  Refit out;
  out.converged = fit.converged && std::isfinite(fit.V);
  if (!out.converged) return out;
  out.gain = course.fit.V - fit.V;
  out.value = in_stamps + fit.at.theta(a);
  const Index coefficients = 2 * rig.element_count();
  out.moves = fit.at.theta.head(coefficients) - course.fit.at.theta.head(coefficients);
  double variance = fit.covariance(a, a);
  out.left = leftover(model, data, fit.at, course.noise, course.size);
  if (fit.pass.blocks >= 8 && out.left.least_p < kNotWhite)
    variance = std::max(variance, fit.covariance.row(a).dot(fit.pass.meat * fit.covariance.col(a)));
  out.u = std::sqrt(variance);
  return out;
}

}  // namespace dwell
