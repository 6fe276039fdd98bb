// The modal fit of one channel, solved: its steady motion, the amplitudes of its modes and its noise.
#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"

namespace dwell {

struct ModalSolution {
  // most: as many modes at most. All memory is allocated here.
  ModalSolution(int harmonics, Eigen::Index most)
      : theta(ModalLayout{harmonics, most}.linear()), covariance(2 * most, 2 * most) {}

  Eigen::VectorXd theta;                 // the linear parameters, as ModalLayout orders them
  Eigen::MatrixXd covariance;            // of the modal amplitudes, the poles given
  double prior = 0.0, line_prior = 0.0;  // information of the amplitudes' prior, of what decays and of lines, times σ²
  double sigma2 = 0.0;                   // variance of the noise, the channel's unit squared
  bool usable = false;

  // (Re, Im) of a mode's amplitude at t0, the covariance of these, and the mean variance of either.
  [[nodiscard]] Eigen::Vector2d amplitude(const ModalLayout& layout, Eigen::Index m) const noexcept {
    return theta.segment<2>(layout.amplitude(m));
  }
  [[nodiscard]] Eigen::Matrix2d amplitude_covariance(Eigen::Index m) const noexcept {
    return covariance.block<2, 2>(2 * m, 2 * m);
  }
  [[nodiscard]] double amplitude_variance(Eigen::Index m) const noexcept {
    return 0.5 * (covariance(2 * m, 2 * m) + covariance(2 * m + 1, 2 * m + 1));
  }

  // b = J ρ: coefficients of the two derivatives of mode m, by its pole's relative change ρ (Re, Im). b_m = a_m ρ_m.
  [[nodiscard]] Eigen::Matrix2d by_pole(const ModalLayout& layout, const ModalMotion& motion,
                                        Eigen::Index m) const noexcept {
    const Eigen::Vector2d a = amplitude(layout, m);
    // Of a steady line the frequency alone is open.
    const double decays = motion.decays(static_cast<std::size_t>(m)) ? 1.0 : 0.0;
    Eigen::Matrix2d slope;
    slope << decays * a(0), -a(1), decays * a(1), a(0);
    return slope;
  }
  // Likewise of the derivatives by the relative change of ω: of p sin ωu + q cos ωu it is ωu (p cos ωu - q sin ωu).
  [[nodiscard]] Eigen::Vector2d by_omega(const ModalLayout& layout) const noexcept {
    return {-theta(layout.cosine(1)), theta(layout.sine(1))};
  }
};

}  // namespace dwell
