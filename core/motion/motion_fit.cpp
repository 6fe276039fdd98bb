#include "core/motion/motion_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/motion/step_control.hpp"
#include "core/motion/told_inverse.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Eigenvalues below: the score in that direction is mostly rounding, so that it does not count for convergence.
constexpr double kHardlyTold = 1e-8;
// A logarithm moves by no more than this in a step, a coefficient by this part of the element's dynamic stiffness.
constexpr double kLogStep = 3.0, kCoefficientStep = 0.7;
// A search that stops early, with no passes left or no step that gains, has still converged with less than this left:
// 0.3 standard deviations.
constexpr double kGoodEnough = 0.1;

class Search {
 public:
  Search(const MotionModel& model, const MotionData& data, const FitLimits& limits)
      : model_(model), data_(data), limits_(limits) {}

  MotionFit run(MotionUnknowns start) {
    MotionFit best = evaluated(std::move(start));
    if (!std::isfinite(best.V)) {
      best.left = std::numeric_limits<double>::quiet_NaN();
      return best;
    }
    solve_linear(best);
    for (StepControl control;;) {
      hold_at_bounds(best);
      const VectorXd g = score(best);
      const ToldInverse inverse(information(best), used_);
      best.left = g.dot(inverse.times(g, kHardlyTold));
      // Asked only here, where `left` is that of `best`: a step that was just taken may have far to go.
      if (best.left < limits_.gain || best.passes >= limits_.passes || control.spent()) break;
      const VectorXd step = -inverse.times(g, control.damping());
      MotionFit next = evaluated(moved(best.at, control.factor() * step));
      next.passes = ++best.passes;
      control.learn(2 * (best.V - next.V) / -g.dot(step));
      if (next.V < best.V) best = std::move(next);
    }
    best.converged = best.left < std::max(limits_.gain, kGoodEnough);
    finish(best);
    return best;
  }

 private:
  [[nodiscard]] MotionFit evaluated(MotionUnknowns at) const {
    if (limits_.stop.stop_requested()) throw Stopped();
    MotionFit fit;
    fit.at = std::move(at);
    fit.pass = evaluate(model_, data_, fit.at, {.block_s = limits_.block_s});
    fit.V = fit.pass.V;
    for (Index a = 0; a < fit.at.theta.size(); ++a)
      if (const double u = prior_u(a); u > 0) fit.V += 0.5 * fit.at.theta(a) * fit.at.theta(a) / (u * u);
    return fit;
  }
  [[nodiscard]] double prior_u(Index a) const { return model_.parameters()[static_cast<std::size_t>(a)].prior_u; }
  [[nodiscard]] MatrixXd information(const MotionFit& fit) const {
    MatrixXd H = fit.pass.information;
    for (Index a = 0; a < fit.at.theta.size(); ++a)
      if (const double u = prior_u(a); u > 0) H(a, a) += 1 / (u * u);
    return H;
  }
  [[nodiscard]] VectorXd score(const MotionFit& fit) const {
    VectorXd g = fit.pass.score;
    for (Index a = 0; a < fit.at.theta.size(); ++a)
      if (const double u = prior_u(a); u > 0) g(a) += fit.at.theta(a) / (u * u);
    return g;
  }

  // The state and the biases at these θ: the innovations are linear in them.
  void solve_linear(MotionFit& fit) {
    used_.assign(static_cast<std::size_t>(fit.pass.score.size()), true);
    std::fill_n(used_.begin(), fit.at.theta.size(), false);
    const VectorXd step = -ToldInverse(fit.pass.information, used_).times(fit.pass.score, 0.0);
    MotionFit next = evaluated(moved(fit.at, step));
    if (next.V < fit.V) fit = std::move(next);
    fit.passes = 2;
    std::fill(used_.begin(), used_.end(), true);
  }

  // A parameter at its bound that wants to go below is held there.
  void hold_at_bounds(const MotionFit& fit) {
    for (Index a = 0; a < limits_.lowest.size(); ++a)
      used_[static_cast<std::size_t>(a)] = fit.at.theta(a) > limits_.lowest(a) || fit.pass.score(a) < 0;
  }

  [[nodiscard]] MotionUnknowns moved(const MotionUnknowns& from, const VectorXd& step) const {
    MotionUnknowns to = from;
    for (Index a = 0; a < from.theta.size(); ++a) {
      const double limit = largest_step(from.theta, a);
      to.theta(a) += std::clamp(step(a), -limit, limit);
    }
    for (Index a = 0; a < limits_.lowest.size(); ++a) to.theta(a) = std::max(to.theta(a), limits_.lowest(a));
    to.initial += step.segment(from.theta.size(), from.initial.size());
    to.bias += step.tail(from.bias.size());
    return to;
  }
  [[nodiscard]] double largest_step(const VectorXd& theta, Index a) const {
    const Parameter& p = model_.parameters()[static_cast<std::size_t>(a)];
    if (p.what == Unknown::noise || p.what == Unknown::intensity) return kLogStep;
    if (p.what != Unknown::stiffness && p.what != Unknown::damping)
      return p.prior_u > 0 ? 5 * p.prior_u : std::numeric_limits<double>::infinity();
    // Stiffness and damping of an element stand side by side (free_parameters()).
    const double omega = 2 * std::numbers::pi * model_.rig().excitation.frequency_hz;
    const Index c = p.what == Unknown::stiffness ? a : a - 1;
    const double size = std::hypot(theta(c), omega * theta(c + 1));
    return kCoefficientStep * (p.what == Unknown::stiffness ? size : size / omega);
  }

  void finish(MotionFit& fit) {
    hold_at_bounds(fit);
    const ToldInverse inverse(information(fit), used_);
    fit.covariance = inverse.matrix();
    fit.undetermined = inverse.undetermined();
    fit.converged = fit.converged && fit.covariance.allFinite();
  }

  const MotionModel& model_;
  const MotionData& data_;
  const FitLimits& limits_;
  std::vector<bool> used_;
};

}  // namespace

MotionFit fit_motion(const MotionModel& model, const MotionData& data, MotionUnknowns start, const FitLimits& limits) {
  return Search(model, data, limits).run(std::move(start));
}

}  // namespace dwell
