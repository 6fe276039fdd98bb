// Keeps the poles now believed of a hold and searches for better ones. A Gauss-Newton step on the poles and ω is kept
// where it lowers the misfit. A step that goes too far is shortened.
#pragma once

#include <algorithm>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/residual_noise.hpp"

namespace dwell {

// Poles in rad/s; Re = 0: a steady line such as mains hum. In every fit the poles of `beside` come first.
struct PoleSet {
  std::vector<std::complex<double>> chain;   // natural oscillations of the chain
  std::vector<std::complex<double>> beside;  // other oscillations: a bracket that rings, hum

  void clear() noexcept {
    chain.clear();
    beside.clear();
  }
  // Whether a steady line beside the drive is fitted.
  [[nodiscard]] bool hums() const noexcept {
    return std::any_of(beside.begin(), beside.end(), [](std::complex<double> pole) { return pole.real() == 0; });
  }
};

// Bound to one thread. No allocation but in the constructor.
class PoleSearch {
 public:
  static constexpr double kTrust = 0.05;        // damping of one step: width of a pole's relative change
  static constexpr double kTrustOmega = 0.005;  // the same of the drive's frequency
  static constexpr int kManySteps = 8;          // refinement steps for poles that may be far off

  // rig, fit and noise must outlive this.
  PoleSearch(const Rig& rig, HoldFit& fit, ResidualNoise& noise);

  // The poles now believed.
  [[nodiscard]] PoleSet& poles() noexcept { return poles_; }
  [[nodiscard]] const PoleSet& poles() const noexcept { return poles_; }
  // The poles of the believed fit: as many as poles().beside has, then the chain's. take_best() makes them poles().
  [[nodiscard]] std::vector<std::complex<double>>& best() noexcept { return best_; }
  void take_best();
  // Poles to be tried by try_trial().
  [[nodiscard]] std::vector<std::complex<double>>& trial() noexcept { return trial_; }

  // Writes to `out` the poles beside the chain, then those of `chain` whose modes have not decayed where the fit
  // begins. Poles that the data cannot tell apart are entered once. free_since_ns: when all oscillations began.
  void still_there(std::span<const std::complex<double>> chain, std::int64_t free_since_ns, const HoldNow& now,
                   std::vector<std::complex<double>>& out) const;

  // Fits anew with best(); omega: ω at the fit's begin, rad/s. Returns the misfit.
  double fit_best(double omega, const HoldNow& now) { return fit_.anew(omega, best_, now.channels); }
  // Fits with trial() and this ω. A misfit below `misfit` makes trial() best(). Returns the misfit of best().
  double try_trial(double omega, double misfit, const HoldNow& now);
  // Makes up to `steps` steps from best(), whose misfit is given, while they lower it. Then compares the halves of the
  // residuals (ResidualNoise). Returns the misfit of best().
  double refine(double misfit, int steps, const HoldNow& now);

 private:
  const Rig& rig_;
  HoldFit& fit_;
  ResidualNoise& noise_;
  PoleSet poles_;
  std::vector<std::complex<double>> best_, trial_;
};

}  // namespace dwell
