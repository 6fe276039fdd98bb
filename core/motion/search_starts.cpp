#include "core/motion/search_starts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/angle.hpp"
#include "core/motion/leftover.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Part of the random walk of acceleration that alone would make the drive's sine. Halved or doubled together with the
// other starting values, of forty rigs in random motion one, one and none come to no estimate, and the rms error stays
// within its scatter (docs/figures.md).
constexpr double kWanders = 1e-3;
const double kAbove = -std::log(kWanders);  // from ln q of that part to ln q of the whole walk
// Loss factor to begin with where the readings tell none. The search changes it within a few steps.
constexpr double kLossFactor = 0.1;

// Keeps the fit with the lower V. Its passes are those of both.
void keep_lower(MotionFit& fit, MotionFit other) {
  const int passes = fit.passes + other.passes;
  if (other.V < fit.V || !std::isfinite(fit.V)) fit = std::move(other);
  fit.passes = passes;
}

// Whether a fit leaves no more of any channel than its noise from reading to reading.
bool leaves_only_noise(const MotionModel& model, const MotionFit& fit, const std::vector<double>& noise) {
  if (!fit.converged) return false;
  const auto& parameters = model.parameters();
  for (std::size_t a = 0; a < parameters.size(); ++a)
    if (parameters[a].what == Unknown::noise &&
        std::exp(fit.at.theta(static_cast<Index>(a))) >
            kMoreThanNoise * noise[static_cast<std::size_t>(parameters[a].index)])
      return false;
  return true;
}

}  // namespace

void SearchStarts::add_stretch(double amplitude) {
  // A random walk with A² ω/2 per second would make a sine's acceleration.
  const double omega0 = kTwoPi * rig_.excitation.frequency_hz;
  ln_q_.push_back(std::log(std::max(kWanders * 0.5 * amplitude * amplitude * omega0, 1e-30)));
}

void SearchStarts::take_weak_form(const WeakForm& weak) {
  const double omega = kTwoPi * rig_.excitation.frequency_hz;
  const double mass = rig_.masses.empty() ? 1.0 : *std::max_element(rig_.masses.begin(), rig_.masses.end());
  coefficients_.resize(2 * rig_.element_count());
  for (Index e = 0; e < rig_.element_count(); ++e) {
    const double c = e < weak.stiffness.size() ? weak.stiffness(e) : kNaN;
    const double r = e < weak.damping.size() ? weak.damping(e) : kNaN;
    coefficients_(2 * e) = std::isfinite(c) ? c : mass * omega * omega;
    coefficients_(2 * e + 1) = std::isfinite(r) ? r : kLossFactor * mass * omega;
  }
  largest_ = coefficients_;
  for (Index e = 0; e < weak.coherence.size(); ++e) {
    if (!(weak.coherence(e) > 0)) continue;
    largest_.segment(2 * e, 2) /= weak.coherence(e);
    // A small coherence makes H2 of the stiffness large. The damping beside it is then mostly noise.
    const double most = kLossFactor * std::abs(largest_(2 * e)) / omega;
    largest_(2 * e + 1) = std::clamp(largest_(2 * e + 1), -most, most);
  }
}

MotionFit SearchStarts::first(const MotionModel& model, const MotionData& data, const MotionUnknowns& at,
                              const FitLimits& limits, const std::vector<double>& noise) const {
  MotionFit fit = fit_motion(model, data, at, limits);
  // From low intensities, noise of the table's channel may come to stand for what the table does beside its drive. From
  // high ones, the search of a nearly pure drive may not come to its end.
  MotionUnknowns above = at;
  above.theta.segment(coefficients_.size(), stretches()).array() += kAbove;
  keep_lower(fit, fit_motion(model, data, std::move(above), limits));
  // Coefficients that noise makes too small by a half may lead into a lesser maximum.
  if (!leaves_only_noise(model, fit, noise))
    keep_lower(fit, fit_motion(model, data, with_coefficients(at, largest_), limits));
  return fit;
}

MotionFit SearchStarts::longer(const MotionModel& model, const MotionData& data, const MotionUnknowns& at,
                               const FitLimits& limits, std::int64_t fitted_ns) const {
  const MotionUnknowns start = with_newest_again(model, data, at, fitted_ns);
  MotionFit fit = fit_motion(model, data, start, limits);
  if (!fit.converged) keep_lower(fit, fit_motion(model, data, with_coefficients(start, coefficients_), limits));
  return fit;
}

// The intensity of the newest stretch so far may be next to none: few readings tell of it, or the table moved as a pure
// sine. If the table moves differently from there on, a search from this intensity comes to no end. The same holds if
// later stretches begin with too little. So V is compared for four starts: the newest intensity as it is, reset low, or
// reset high with all later ones; and only the later ones high.
MotionUnknowns SearchStarts::with_newest_again(const MotionModel& model, const MotionData& data,
                                               const MotionUnknowns& at, std::int64_t fitted_ns) const {
  int newest = 0;
  for (const MotionStretch& stretch : data.stretches)
    if (stretch.from_ns <= fitted_ns) newest = stretch.intensity;
  if (newest >= stretches()) return at;  // of events
  const auto with = [&](int first, double above) {
    MotionUnknowns out = at;
    for (int i = first; i < stretches(); ++i) out.theta(coefficients_.size() + i) = ln_q(i) + above;
    return out;
  };
  MotionUnknowns best = at;
  double least = evaluate(model, data, at, {.derivatives = false}).V;
  for (MotionUnknowns& other : std::array{with(newest, 0.0), with(newest, kAbove), with(newest + 1, kAbove)}) {
    const double V = evaluate(model, data, other, {.derivatives = false}).V;
    if (!(V < least) && std::isfinite(least)) continue;
    least = V;
    best = std::move(other);
  }
  return best;
}

MotionUnknowns SearchStarts::with_coefficients(MotionUnknowns at, const VectorXd& coefficients) const {
  at.theta.head(coefficients.size()) = coefficients;
  return at;
}

}  // namespace dwell
