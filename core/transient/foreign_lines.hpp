// What swings beside the drive and the chain: a bracket that rings, mains hum, a harmonic of the drive above those that
// are fitted. Such a line is looked for in what the fit leaves over, and then judged: does it decay, or is it steady?
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

  // masses: of the chain. The others must outlive this.
  ForeignLines(PoleSearch& search, HoldFit& fit, ResidualNoise& noise, std::size_t masses);

  // Adds a pole to those beside the chain: the strongest line of the residuals at the beginning of the fit, where it is
  // strongest, on top of what noise shows now and then. false: there is none, or there are as many poles as there may
  // be. O(samples · lines).
  bool find(const HoldNow& now);
  // Whether each of them is steady. An oscillation that does not decay is no transient. At the mains' frequencies that
  // is believed unless the data speak against it; at others after a long time. Fits anew where it must ask the data.
  void judge(const HoldNow& now);

 private:
  // ω of the strongest line in the first stretch_s of the fit, rad/s; 0: none stands out.
  [[nodiscard]] double strongest_line(double stretch_s, const HoldNow& now) noexcept;
  [[nodiscard]] bool near_mains(std::complex<double> pole, double u) const noexcept;
  [[nodiscard]] bool near_harmonic(std::complex<double> pole, double u) const noexcept;
  void try_other_kind(std::size_t i, double seen_s, const HoldNow& now);

  PoleSearch& search_;
  HoldFit& fit_;
  ResidualNoise& noise_;
  std::vector<std::complex<double>> spectrum_;  // of one channel's residuals
  std::vector<std::complex<double>> before_;    // the poles before another kind was tried
};

}  // namespace dwell
