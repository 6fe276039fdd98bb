// Fits steady harmonics and decaying natural oscillations together to the samples of one hold (docs/method.md,
// Settling). The fit tells how much of the transient is left, and what to subtract.
//
//   s_i = b + Σ_h [ p_h sin hωu_i + q_h cos hωu_i ] + Σ_m Re( a_m exp(λ_m u_i) ) + e_i ,    u_i = t_i - t_0
//
// Each channel has its own b, p, q and a; all share the poles λ_m. The poles start from the identified chain and are
// refined on the data: Gauss-Newton on λ and ω with all linear parameters eliminated (Golub and Pereyra's variable
// projection as simplified by Kaufman). A Gaussian prior as wide as the range that the channel has shown keeps the
// amplitudes finite and the fit solvable at any time. Where the data cannot yet tell a slow mode from the steady
// motion, the width of the prior is the amplitude's uncertainty.
//
// ModalRegressors gives the regressors at an instant, SharedSums their sums in each channel. LinearPart solves a
// channel or eliminates its linear parameters. PoleStep improves poles and ω; PoleErrors propagates their uncertainty.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/fit/frequency_prior.hpp"
#include "core/transient/linear_part.hpp"
#include "core/transient/modal_motion.hpp"
#include "core/transient/modal_regressors.hpp"
#include "core/transient/modal_solution.hpp"
#include "core/transient/pole_errors.hpp"
#include "core/transient/pole_step.hpp"
#include "core/transient/shared_sums.hpp"

namespace dwell {

class ModalFit {
 public:
  // modes: capacity in poles. All memory is allocated here: about 16·(2H+3+4·modes)² bytes a channel.
  ModalFit(int channels, int harmonics, int modes);

  // Sets the prior of ω. Call before the first restart.
  void state_omega(const FrequencyPrior& stated) noexcept { stated_ = stated; }

  // Empties the sums. poles: as in ModalMotion; those beyond the capacity are left out. omega: of the drive at t0,
  // rad/s. rate: its drift, rad/s²; with it hωu above is hθ, θ = ωu + rate u²/2.
  void restart(double omega, double rate, std::int64_t t0_ns, std::span<const std::complex<double>> poles) noexcept;
  // Adds a sample, at t >= t_0 and later than the channel's sample before. Returns the number of multiplications:
  // O((2H+3+4·modes)²) for the first sample of an instant, else O(2H+3+4·modes). No allocation.
  double add(int channel, std::int64_t t_ns, double value) noexcept;

  // Sets the variance of the noise from which the channel's next solution starts, its unit squared.
  void expect(int channel, double sigma2) noexcept { at(channel).solution.sigma2 = sigma2; }
  // Number of multiplications in solve(), in residual(), and in step_poles() or propagate_poles().
  [[nodiscard]] double work_of_solution() const noexcept {
    return static_cast<double>(layout().linear() * layout().linear() * (layout().linear() + 2 * layout().modal()));
  }
  [[nodiscard]] double work_of_residual() const noexcept { return static_cast<double>(4 * layout().all()); }
  [[nodiscard]] double work_of_poles() const noexcept {
    return static_cast<double>(channels() * layout().all() * layout().all() * layout().slopes());
  }

  // Solves one channel. range, line_range: standard deviations of the amplitudes' priors, for modes that decay and for
  // steady lines, in the channel's unit. false: too few samples, or the normal matrix is singular.
  bool solve(int channel, double range, double line_range) noexcept;

  // Σ N ln σ² over the solved channels, plus ((ω - ω_0)/u)² by the prior of ω. Better poles make it smaller.
  [[nodiscard]] double misfit() const noexcept;
  // Makes one Gauss-Newton step on the poles and ω, from all solved channels and the prior of ω. trust, trust_omega: as
  // PoleStep::take. The sums stay as they are: to use moved_poles(), restart and add again.
  void step_poles(double trust, double trust_omega) noexcept;
  // The poles after the last step, rad/s.
  [[nodiscard]] std::span<const std::complex<double>> moved_poles() const noexcept {
    return {step_.poles().data(), regressors_.motion().count()};
  }
  // ω after the last step, rad/s.
  [[nodiscard]] double moved_omega() const noexcept { return step_.omega(); }

  // Adds the uncertainty of the poles and of ω to left() and spread(). It follows from the channels as now solved and a
  // prior of width max(1/T, |Re λ|) on each pole, T the time seen. A new solution of a channel discards it: call again.
  // omega_known: ω is given. O((2H+1+2·modes)²·modes) a channel, no allocation.
  void propagate_poles(bool omega_known) noexcept;

  // Relative changes (Re, Im) of the poles in the last step, then that of ω.
  using Change = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * ModalMotion::kMaxModes + 1, 1>;
  [[nodiscard]] Change last_change() const noexcept;
  // Covariance of the relative errors of the poles (Re, Im) and of ω, by propagate_poles().
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> propagated() const noexcept {
    return errors_.covariance().topLeftCorner(layout().modal() + 1, layout().modal() + 1);
  }
  // Derivative of (Re, Im) of a mode's amplitude by these errors. has_propagated: whether it is known.
  [[nodiscard]] bool has_propagated(int channel) const noexcept { return usable(channel) && at(channel).errors.known; }
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> amplitude_by_poles(int channel, std::size_t mode) const noexcept {
    return at(channel).errors.by_poles.block(2 * static_cast<Eigen::Index>(mode), 0, 2, layout().modal() + 1);
  }

  // Standard uncertainty of a pole at the last step, rad/s, either component, as PoleStep::u_pole.
  [[nodiscard]] double u_pole(std::size_t m) const noexcept { return step_.u_pole(m); }
  // Covariance of (Re, Im) of a pole at the last step, (rad/s)², without the damping: large where the data tell little.
  [[nodiscard]] Eigen::Matrix2d pole_covariance(std::size_t m) const noexcept;
  // χ² of the channel that disagrees most with the common pole, at the last step; two degrees of freedom at most. A
  // natural oscillation has one pole in all channels. A bracket that rings beside it draws that of its own channel.
  [[nodiscard]] double disagreement(std::size_t m) const noexcept { return step_.disagreement(m); }
  // The largest move of a pole or of ω in the last step, in its standard deviations.
  [[nodiscard]] double last_step() const noexcept { return step_.length(); }

  [[nodiscard]] std::span<const std::complex<double>> poles() const noexcept { return regressors_.motion().poles(); }
  [[nodiscard]] double omega() const noexcept { return regressors_.motion().omega(); }
  [[nodiscard]] double rate() const noexcept { return regressors_.motion().rate(); }
  // θ at t, rad.
  [[nodiscard]] double angle(std::int64_t t_ns) const noexcept { return regressors_.motion().angle(t_ns); }
  [[nodiscard]] std::int64_t t0_ns() const noexcept { return regressors_.motion().t0_ns(); }
  [[nodiscard]] bool usable(int channel) const noexcept { return at(channel).solution.usable; }
  // Phasor of harmonic h of the reading at t_0, in the channel's unit.
  [[nodiscard]] std::complex<double> phasor(int channel, int h) const noexcept;
  [[nodiscard]] double variance(int channel) const noexcept { return at(channel).solution.sigma2; }
  [[nodiscard]] int parameters() const noexcept { return static_cast<int>(layout().linear()); }
  [[nodiscard]] double samples(int channel) const noexcept { return sums_.samples(channel); }

  // Amplitude of a mode in a channel at t_0; its standard deviation, either component, poles and ω taken as exact.
  [[nodiscard]] std::complex<double> amplitude(int channel, std::size_t mode) const noexcept;
  [[nodiscard]] double u_amplitude(int channel, std::size_t mode) const noexcept;

  // Covariance of (Re, Im) of that amplitude, poles and ω taken as exact.
  [[nodiscard]] Eigen::Matrix2d amplitude_covariance(int channel, std::size_t mode) const noexcept {
    return at(channel).solution.amplitude_covariance(static_cast<Eigen::Index>(mode));
  }

  // Whether the amplitude of a mode stands out of the noise in any channel.
  [[nodiscard]] bool shows(std::size_t mode) const noexcept;
  // Whether the amplitudes of all channels together exceed noise: at one given pole noise does so once in 10⁹.
  [[nodiscard]] bool certain(std::size_t mode) const noexcept;

  // What may be left of the transient from t on, in the channel's unit. envelope: of the modes that stand out of the
  // noise. u: standard deviation of all modes together. swing: their largest value, as fitted, within half a cycle of
  // the drive from t on. Two modes that cancel each other have a large envelope and a small swing.
  struct Left {
    double envelope, u, swing;
  };
  [[nodiscard]] Left left(int channel, std::int64_t t_ns) const noexcept;

  // Envelope of mode m at t plus three standard deviations of its amplitude, in the channel's unit.
  [[nodiscard]] double most(int channel, std::size_t m, std::int64_t t_ns) const noexcept;
  // Takes mode m as zero from t on, until the next restart: it then costs nothing.
  void fade(std::size_t m, std::int64_t t_ns) noexcept { regressors_.fade(m, t_ns); }
  [[nodiscard]] std::int64_t faded_ns(std::size_t m) const noexcept { return regressors_.faded_ns(m); }

  // The reading less the fit. The fit includes the steady lines.
  [[nodiscard]] double residual(int channel, std::int64_t t_ns, double value) noexcept;
  // The transient and the steady lines at t, in the channel's unit; 0: the channel is not solved.
  [[nodiscard]] double disturbance(int channel, std::int64_t t_ns) noexcept;
  // B += (sin ωu, cos ωu)' x at t, x the regressors of the modes, then their derivatives by the poles. B turns errors
  // of the amplitudes and of the poles into errors of the steady phasor. B is 2 × modal_regressors().
  void overlap_at(std::int64_t t_ns, Eigen::Matrix<double, 2, Eigen::Dynamic>& B) noexcept;
  // Covariance of (Σ sin ωu e, Σ cos ωu e) = B Cov B', e the error of disturbance() at a reading, B from overlap_at().
  [[nodiscard]] Eigen::Matrix2d spread(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept;
  // (Σ sin ωu e, Σ cos ωu e), e = disturbance() at a reading, B from overlap_at().
  [[nodiscard]] Eigen::Vector2d taken_out(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept;
  [[nodiscard]] int modal_regressors() const noexcept { return 4 * static_cast<int>(regressors_.motion().capacity()); }

 private:
  struct PerChannel {
    ModalSolution solution;
    PoleErrors::Effect errors;  // of the poles: their effect on the solution
    // Covariance of the modal amplitudes and, where errors are known, of the derivatives' coefficients.
    [[nodiscard]] const Eigen::MatrixXd& covariance() const noexcept {
      return errors.known ? errors.whole : solution.covariance;
    }
  };
  [[nodiscard]] int channels() const noexcept { return static_cast<int>(channels_.size()); }
  [[nodiscard]] PerChannel& at(int channel) noexcept { return channels_[static_cast<std::size_t>(channel)]; }
  [[nodiscard]] const PerChannel& at(int channel) const noexcept {
    return channels_[static_cast<std::size_t>(channel)];
  }
  [[nodiscard]] const ModalLayout& layout() const noexcept { return regressors_.layout(); }
  // All modes together u seconds after t0, as fitted, and the variance of this sum.
  struct Swing {
    double value, variance;
  };
  [[nodiscard]] Swing swing_at(const PerChannel& of, double u) const noexcept;
  // Number of valid rows of channel.covariance().
  [[nodiscard]] Eigen::Index errors_of(const PerChannel& channel) const noexcept {
    return channel.errors.known ? 2 * layout().modal() : layout().modal();
  }

  FrequencyPrior stated_;
  ModalRegressors regressors_;
  SharedSums sums_;
  std::vector<PerChannel> channels_;
  LinearPart linear_;
  PoleStep step_;
  PoleErrors errors_;
  std::int64_t newest_ns_ = 0;
};

}  // namespace dwell
