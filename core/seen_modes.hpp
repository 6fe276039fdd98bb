// The natural oscillations of one hold as the samples show them: poles refined on the data, which depend on instants
// alone, not on masses, scales or delays. What the identified chain's eigenvalues are held against
// (core/pole_check.hpp).
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/modal_fit.hpp"

namespace dwell {

struct SeenMode {
  std::complex<double> pole;   // rad/s, Im > 0
  Eigen::Matrix2d covariance;  // of (Re, Im), (rad/s)²
  // Per channel, of its reading: magnitude of the amplitude and its standard deviation, either component; u = 0: the
  // channel has no part in the fit.
  std::vector<double> amplitude, u_amplitude;
};

class SeenModes {
 public:
  // All memory is allocated here.
  explicit SeenModes(int channels);
  void clear() noexcept { count_ = 0; }
  // Those that stand out of the noise and whose poles the data resolve. until_ns: the end of what `fit` has seen; of
  // its last step (ModalFit::refined) poles and covariance are taken. left_over: per channel, variance of the fit's
  // residuals beyond the noise. What is left over may be a part of a mode: a residual of rms ρ beside an amplitude |a|
  // moves a pole by up to √2 ρ/|a| of its rate, which is added to the covariance. No allocation.
  void take(const ModalFit& fit, std::span<const std::complex<double>> refined, std::int64_t until_ns,
            std::span<const double> left_over) noexcept;
  [[nodiscard]] std::span<const SeenMode> modes() const noexcept { return {modes_.data(), count_}; }

 private:
  std::array<SeenMode, ModalFit::kMaxModes> modes_;
  std::size_t count_ = 0;
};

}  // namespace dwell
