// The poles of a hold: those now believed, and the search for better ones. A step of the fit (Gauss-Newton on the
// poles and on ω) is taken where it explains the data better; one that goes too far is shortened.
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

// In every fit those beside the chain come first. rad/s; Re = 0: a steady line, as mains hum.
struct PoleSet {
  std::vector<std::complex<double>> chain;   // of the chain
  std::vector<std::complex<double>> beside;  // of what swings beside it: a bracket that rings, hum

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
  static constexpr double kTrust = 0.05;  // relative change of a pole in one step, as far as the data leave it open
  static constexpr double kTrustOmega = 0.005;  // of the drive's frequency likewise
  static constexpr int kManySteps = 8;          // of refinement, for poles that are far off

  // rig, fit and noise must outlive this.
  PoleSearch(const Rig& rig, HoldFit& fit, ResidualNoise& noise);

  // The poles now believed.
  [[nodiscard]] PoleSet& poles() noexcept { return poles_; }
  [[nodiscard]] const PoleSet& poles() const noexcept { return poles_; }
  // Those of the believed fit, which become poles() by take_best(): as many beside the chain as poles().beside has,
  // then the chain's.
  [[nodiscard]] std::vector<std::complex<double>>& best() noexcept { return best_; }
  void take_best();
  // Others that are to be tried.
  [[nodiscard]] std::vector<std::complex<double>>& trial() noexcept { return trial_; }

  // Into `out`: the poles beside the chain, then those of `chain` that are still there where the fit begins, each once.
  // free_since_ns: where all oscillations began.
  void still_there(std::span<const std::complex<double>> chain, std::int64_t free_since_ns, const HoldNow& now,
                   std::vector<std::complex<double>>& out) const;

  // The fit anew by best() and ω at its begin; its misfit.
  double fit_best(double omega, const HoldNow& now) { return fit_.anew(omega, best_, now.channels); }
  // The fit by trial() and ω, which becomes best() where it explains the data better than `misfit`. The misfit of
  // best().
  double try_trial(double omega, double misfit, const HoldNow& now);
  // So many steps from best(), of that misfit, while they help; then looks at the residuals. The misfit of best().
  double refine(double misfit, int steps, const HoldNow& now);

 private:
  const Rig& rig_;
  HoldFit& fit_;
  ResidualNoise& noise_;
  PoleSet poles_;
  std::vector<std::complex<double>> best_, trial_;
};

}  // namespace dwell
