#include "core/transient/pole_search.hpp"

#include <cmath>

#include "core/base/complex.hpp"
#include "core/drive/refine.hpp"
#include "core/transient/fit_limits.hpp"

namespace dwell {
namespace {

constexpr double kGone = 1e-6;        // part of its amplitude below which a mode has decayed where the fit begins
constexpr double kLeastDecay = 1e-3;  // least decay rate of a chain's pole, as part of |λ|
constexpr double kSameTurn = 0.3;     // poles that turn apart by less over the fit are one, rad

}  // namespace

PoleSearch::PoleSearch(const Rig& rig, HoldFit& fit, ResidualNoise& noise) : rig_(rig), fit_(fit), noise_(noise) {
  for (std::vector<Complex>* poles : {&poles_.chain, &poles_.beside, &best_, &trial_})
    poles->reserve(4 * rig.masses.size() + 4);
}

void PoleSearch::take_best() {
  for (std::size_t i = 0; i < poles_.beside.size(); ++i) poles_.beside[i] = best_[i];
  poles_.chain.assign(best_.begin() + static_cast<std::ptrdiff_t>(poles_.beside.size()), best_.end());
}

void PoleSearch::still_there(std::span<const Complex> chain, std::int64_t free_since_ns, const HoldNow& now,
                             std::vector<Complex>& out) const {
  const double skipped_s = to_s(fit_.from_ns() - free_since_ns);
  out.assign(poles_.beside.begin(), poles_.beside.end());
  const double seen_s = std::max(to_s(now.now_ns - fit_.from_ns()), now.period_s());
  for (Complex pole : chain) {
    pole.real(std::min(pole.real(), -kLeastDecay * std::abs(pole)));
    if (std::exp(pole.real() * skipped_s) < kGone) continue;
    // Poles that the data cannot tell apart count once.
    if (std::none_of(out.begin(), out.end(),
                     [&](Complex other) { return std::abs(pole - other) * seen_s < kSameTurn; }))
      out.push_back(pole);
  }
}

double PoleSearch::try_trial(double omega, double misfit, const HoldNow& now) {
  if (fit_.attempt(omega, trial_, now.channels, misfit)) best_ = trial_;
  return misfit;
}

double PoleSearch::refine(double misfit, int steps, const HoldNow& now) {
  double best = misfit;
  for (int i = 0; i < steps && fit_.may_fit(); ++i) {
    fit_.fit().step_poles(kTrust, now.omega_given ? 0.0 : kTrustOmega);
    fit_.history().spend(fit_.fit().work_of_poles());
    if (fit_.fit().last_step() < kConverged) break;
    const double w = fit_.fit().omega(), by = (now.omega_given ? w : within_search(rig_, fit_.fit().moved_omega())) - w;
    const auto moved = fit_.fit().moved_poles();
    trial_.assign(moved.begin(), moved.end());
    double better = try_trial(w + by, best, now);
    // With the drive beside a pole the fit is far from linear in both: a step may go too far.
    double part = kShorter;
    for (int shorter = 0; shorter < kShortened && !(better < best) && fit_.may_fit(); ++shorter, part *= kShorter) {
      const auto poles = fit_.fit().poles(), whole = fit_.fit().moved_poles();
      for (std::size_t m = 0; m < poles.size(); ++m) trial_[m] = poles[m] + part * (whole[m] - poles[m]);
      better = try_trial(w + part * by, best, now);
    }
    if (!(better < best)) break;
    best = better;
  }
  noise_.compare_halves(fit_, now.now_ns);
  return best;
}

}  // namespace dwell
