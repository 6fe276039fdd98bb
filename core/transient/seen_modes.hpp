// Collects the natural oscillations of one hold as the samples show them, to hold the identified chain against them
// (core/chain/mode_check.hpp). Poles and amplitudes are refined on the data. Poles depend on instants alone, not on
// masses, scales or delays; amplitudes tell the shape.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transient/hold_now.hpp"
#include "core/transient/modal_fit.hpp"
#include "core/transient/shared_instants.hpp"

namespace dwell {

struct SeenMode {
  std::complex<double> pole;  // rad/s, Im > 0
  // Per channel, amplitude in its reading, all at the same instant; 0 where the channel has no part in the fit.
  Eigen::VectorXcd amplitude;
  // Covariance of (Re a_1, Im a_1, Re a_2, …, Re λ, Im λ).
  Eigen::MatrixXd covariance;
  std::vector<bool> fitted;  // per channel: it has a part in the fit
  double seen_s = 0.0;       // the time from the fit's begin on in which it was seen

  [[nodiscard]] Eigen::Matrix2d pole_covariance() const { return covariance.bottomRightCorner<2, 2>(); }
  // Standard deviation of an amplitude, either component.
  [[nodiscard]] double u_amplitude(Eigen::Index channel) const {
    return std::sqrt(0.5 * covariance.block<2, 2>(2 * channel, 2 * channel).trace());
  }
};

class SeenModes {
 public:
  // All memory is allocated here: 8·(2·channels + 2)² bytes a mode.
  explicit SeenModes(int channels);
  void clear() noexcept { count_ = 0; }
  // Takes the modes that stand out of the noise and whose poles the data resolve. fit: its last step made, its poles'
  // errors propagated. left_over: per channel, variance of the residuals beyond the noise, in its unit squared. Such
  // residuals of rms ρ may belong to a mode. They add an error of up to √2 ρ to an amplitude a, and to the pole √2
  // ρ/|a| of the larger of its decay rate and 1/T, T the time seen. Instants that drift within ± h (slowly refreshed
  // registers) leave residuals too, by the mode's own motion and by the steady one: ρ² = (|λa|² + |ωX_1|²) h²/3.
  // Channels that are read in one transaction share the errors of their instants, and the fit takes their noise as
  // independent. So the fit's covariance grows by widened().
  // A mode that was seen better since clear() stays as it was. No allocation; O(channels²).
  void take(const ModalFit& fit, const HoldNow& now, const SharedInstants& instants,
            std::span<const double> left_over) noexcept;
  [[nodiscard]] std::span<const SeenMode> modes() const noexcept { return {modes_.data(), count_}; }

 private:
  // What a channel's amplitude of mode m may be off beyond noise: variance of either component, its unit squared.
  [[nodiscard]] static double beyond_noise(const ModalFit& fit, std::size_t m, std::size_t channel, const HoldNow& now,
                                           std::span<const double> left_over) noexcept;
  [[nodiscard]] static double extra_pole_variance(const ModalFit& fit, std::size_t m, double scale, const HoldNow& now,
                                                  std::span<const double> left_over) noexcept;
  // By what factor, at most, the variances that follow from independent noise are too small: 1 + (n - 1) τ²/σ², the
  // largest of all channels. n: channels of the same transaction in the fit; τ = ẏ u: the part of a channel's noise σ
  // that the errors u of the instants make (docs/method.md, Cross-check).
  [[nodiscard]] static double widened(const ModalFit& fit, const HoldNow& now, const SharedInstants& instants) noexcept;
  // widened: of the variances. extra: variance to add to either component of the pole.
  void describe(const ModalFit& fit, std::size_t m, const HoldNow& now, std::span<const double> left_over,
                double widened, double extra, SeenMode& mode) noexcept;

  std::array<SeenMode, ModalMotion::kMaxModes> modes_;
  SeenMode now_;
  std::size_t count_ = 0;
};

}  // namespace dwell
