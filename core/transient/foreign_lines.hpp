// Finds and judges lines that neither the drive nor the chain explains: a bracket that rings, mains hum, a harmonic of
// the drive above those that are fitted. A line is found in the residuals of the fit, then judged: decaying or steady.
#pragma once

#include <complex>
#include <vector>

#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/pole_search.hpp"
#include "core/transient/residual_noise.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class ForeignLines {
 public:
  static constexpr std::size_t kMost = 2;  // poles beside the chain's

  // masses: number of the chain's. The others must outlive this.
  ForeignLines(PoleSearch& search, HoldFit& fit, ResidualNoise& noise, std::size_t masses);

  // Appends to the poles beside the chain the strongest line in the residuals of the fit's beginning, if noise
  // alone gives it once in 8000 searches at most. false: no such line, or no room. O(samples · lines).
  bool find(const HoldNow& now);
  // Decides for each pole beside the chain whether it is steady; a steady line is no transient. At the mains'
  // frequencies and the drive's harmonics a line is steady unless the data speak against it. Elsewhere it is steady
  // only after a long time without decay. Fits anew where the data must decide.
  void judge(const HoldNow& now);

 private:
  // ω of the strongest line in the first stretch_s of the fit, rad/s; 0: no line stands out.
  [[nodiscard]] double strongest_line(double stretch_s, const HoldNow& now) noexcept;
  [[nodiscard]] bool near_mains(std::complex<double> pole, double u) const noexcept;
  [[nodiscard]] bool near_harmonic(std::complex<double> pole, double u) const noexcept;
  void try_other_kind(std::size_t i, double seen_s, const HoldNow& now);

  PoleSearch& search_;
  HoldFit& fit_;
  ResidualNoise& noise_;
  std::vector<std::complex<double>> spectrum_;  // Fourier sums of one channel's residuals
  std::vector<std::complex<double>> before_;    // the poles before another kind was tried
};

}  // namespace dwell
