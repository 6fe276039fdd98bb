// The solved modal fit of one channel: its steady motion, the amplitudes of its modes and its noise.
#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"

namespace dwell {

struct ModalSolution {
  // most: capacity in modes. All memory is allocated here.
  ModalSolution(int harmonics, Eigen::Index most)
      : theta(ModalLayout{harmonics, most}.linear()), covariance(2 * most, 2 * most) {}

  Eigen::VectorXd theta;       // the linear parameters, as ModalLayout orders them
  Eigen::MatrixXd covariance;  // of the modal amplitudes; poles and ω taken as exact
  // Information of the amplitudes' priors, times σ²: of modes that decay, of steady lines.
  double prior = 0.0, line_prior = 0.0;
  double sigma2 = 0.0;  // variance of the noise, the channel's unit squared
  bool usable = false;

  // (Re, Im) of the amplitude of mode m at t0; their covariance; the mean of their variances.
  [[nodiscard]] Eigen::Vector2d amplitude(const ModalLayout& layout, Eigen::Index m) const noexcept {
    return theta.segment<2>(layout.amplitude(m));
  }
  [[nodiscard]] Eigen::Matrix2d amplitude_covariance(Eigen::Index m) const noexcept {
    return covariance.block<2, 2>(2 * m, 2 * m);
  }
  [[nodiscard]] double amplitude_variance(Eigen::Index m) const noexcept {
    return 0.5 * (covariance(2 * m, 2 * m) + covariance(2 * m + 1, 2 * m + 1));
  }

  // J in b = J ρ. A relative change ρ (Re, Im) of pole m adds the mode's derivatives with coefficients b = a_m ρ.
  [[nodiscard]] Eigen::Matrix2d by_pole(const ModalLayout& layout, const ModalMotion& motion,
                                        Eigen::Index m) const noexcept {
    const Eigen::Vector2d a = amplitude(layout, m);
    // A steady line can change in frequency only.
    const double decays = motion.decays(static_cast<std::size_t>(m)) ? 1.0 : 0.0;
    Eigen::Matrix2d slope;
    slope << decays * a(0), -a(1), decays * a(1), a(0);
    return slope;
  }
  // The same for a relative change of ω. The derivative of p sin ωu + q cos ωu is ωu (p cos ωu - q sin ωu).
  [[nodiscard]] Eigen::Vector2d by_omega(const ModalLayout& layout) const noexcept {
    return {-theta(layout.cosine(1)), theta(layout.sine(1))};
  }
};

}  // namespace dwell
