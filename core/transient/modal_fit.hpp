// Steady harmonics and decaying natural oscillations fitted together to the samples of one hold (docs/method.md,
// Settling).
//
//   s_i = b + Σ_h [ p_h sin hωu_i + q_h cos hωu_i ] + Σ_m Re( a_m exp(λ_m u_i) ) + e_i ,    u_i = t_i - t_0
//
// per channel, with the poles λ_m shared by all: those of the identified chain, then refined on the data themselves
// (Gauss-Newton on λ and ω with all linear parameters eliminated, Golub and Pereyra's variable projection as simplified
// by Kaufman). An amplitude is not believed to be larger than what the channel has shown: a Gaussian prior of that
// width makes the fit solvable at any time, and makes its uncertainty tell when a slow mode cannot be told yet from the
// steady motion. What is asked of it: how much of the transient is left, and what to subtract.
//
// ModalRegressors gives the regressors at an instant, SharedSums their sums in each channel; LinearPart solves a
// channel or eliminates its linear parameters; PoleStep improves poles and ω; PoleErrors tells what is not known of
// them.
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
  static constexpr int kMaxModes = ModalMotion::kMaxModes;

  // modes: at most this many poles will be given. All memory is allocated here: 16·(2H+3+4·modes)² bytes a channel.
  ModalFit(int channels, int harmonics, int modes);

  // What is stated of ω: a prior of the fit. Before the first restart.
  void state_omega(const FrequencyPrior& stated) noexcept { stated_ = stated; }

  // Empties the sums. poles: rad/s, Im >= 0 (0: a real pole), Re < 0, or Re = 0 for a steady line (mains hum) that is
  // fitted beside but is no transient; those beyond the capacity are left out. omega: of the drive at t0, rad/s; rate:
  // by which it drifts, rad/s², so that hωu above is hθ with θ = ωu + rate u²/2.
  void restart(double omega, double rate, std::int64_t t0_ns, std::span<const std::complex<double>> poles) noexcept;
  // One sample, at t >= t_0, later than the channel's sample before. O((2H+3+4·modes)²) for the first sample of an
  // instant, else O(2H+3+4·modes): the multiplications are returned. No allocation.
  double add(int channel, std::int64_t t_ns, double value) noexcept;

  // The variance of the noise that the next solution of a channel starts from, its unit squared.
  void expect(int channel, double sigma2) noexcept { at(channel).solution.sigma2 = sigma2; }
  // Multiplications in solve(), residual(), and in refined() or propagate_poles(), for whoever has to count them.
  [[nodiscard]] double work_of_solution() const noexcept {
    return static_cast<double>(layout().linear() * layout().linear() * (layout().linear() + 2 * layout().modal()));
  }
  [[nodiscard]] double work_of_residual() const noexcept { return static_cast<double>(4 * layout().all()); }
  [[nodiscard]] double work_of_poles() const noexcept {
    return static_cast<double>(channels() * layout().all() * layout().all() * layout().slopes());
  }

  // Solves one channel. range, line_range: widths of the prior of the amplitudes of what decays and of steady lines, in
  // its unit. false: too few samples.
  bool solve(int channel, double range, double line_range) noexcept;

  // The sum over solved channels of N ln σ², and the square of how far ω is from what is stated, in its standard
  // uncertainties: what a better set of poles makes smaller.
  [[nodiscard]] double misfit() const noexcept;
  // One Gauss-Newton step on the poles, and on ω within `trust_omega` of it (0: it is known), from all solved channels
  // and from what is stated of ω,
  // within `trust` of each pole's magnitude; returns the poles moved. Leaves the sums as they are: restart and add
  // again.
  [[nodiscard]] std::span<const std::complex<double>> refined(double trust, double trust_omega) noexcept;
  // Those poles again.
  [[nodiscard]] std::span<const std::complex<double>> moved_poles() const noexcept {
    return {step_.poles().data(), regressors_.motion().count()};
  }
  // ω after that step, rad/s.
  [[nodiscard]] double refined_omega() const noexcept { return step_.omega(); }

  // Adds to what left() and spread() say what is not known of the poles and of ω: by the channels as now solved, and by
  // a prior of max(1/T, |Re λ|) on each pole, T the time seen. To be called anew after each solution, at which it is
  // forgotten. omega_known: ω is given. O((2H+1+2·modes)²·modes) a channel, no allocation.
  void propagate_poles(bool omega_known) noexcept;

  // Relative changes (Re, Im) of the poles at the last step, then that of ω.
  using Change = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * kMaxModes + 1, 1>;
  [[nodiscard]] Change last_change() const noexcept;
  // Covariance of these relative changes, as propagate_poles() left it.
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> propagated() const noexcept {
    return errors_.covariance().topLeftCorner(layout().modal() + 1, layout().modal() + 1);
  }
  // What they do to (Re, Im) of a mode's amplitude, by propagate_poles(). has_propagated: whether that could be done.
  [[nodiscard]] bool has_propagated(int channel) const noexcept { return usable(channel) && at(channel).errors.known; }
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> amplitude_by_poles(int channel, std::size_t mode) const noexcept {
    return at(channel).errors.by_poles.block(2 * static_cast<Eigen::Index>(mode), 0, 2, layout().modal() + 1);
  }

  // Standard uncertainty of a pole at the last step, rad/s, either component.
  [[nodiscard]] double u_pole(std::size_t m) const noexcept { return step_.u_pole(m); }
  // Covariance of (Re, Im) of a pole at the last step, (rad/s)², from the data alone: an open pole has a large one.
  [[nodiscard]] Eigen::Matrix2d pole_covariance(std::size_t m) const noexcept;
  // χ² of the channel that disagrees most with the common pole, at the last step: two degrees of freedom, or less. A
  // natural oscillation has one pole in all channels; a bracket that rings beside it draws the pole of its own channel
  // alone.
  [[nodiscard]] double disagreement(std::size_t m) const noexcept { return step_.disagreement(m); }
  // How far the last step went, in standard deviations of the poles and of ω.
  [[nodiscard]] double converged() const noexcept { return step_.length(); }

  [[nodiscard]] std::span<const std::complex<double>> poles() const noexcept { return regressors_.motion().poles(); }
  [[nodiscard]] double omega() const noexcept { return regressors_.motion().omega(); }
  [[nodiscard]] double rate() const noexcept { return regressors_.motion().rate(); }
  // θ at t, rad.
  [[nodiscard]] double angle(std::int64_t t_ns) const noexcept { return regressors_.motion().angle(t_ns); }
  [[nodiscard]] std::int64_t t0_ns() const noexcept { return regressors_.motion().t0_ns(); }
  [[nodiscard]] bool usable(int channel) const noexcept { return at(channel).solution.usable; }
  // Phasor of harmonic h at t_0, of the reading.
  [[nodiscard]] std::complex<double> phasor(int channel, int h) const noexcept;
  [[nodiscard]] double variance(int channel) const noexcept { return at(channel).solution.sigma2; }
  [[nodiscard]] int parameters() const noexcept { return static_cast<int>(layout().linear()); }
  [[nodiscard]] double samples(int channel) const noexcept { return sums_.samples(channel); }

  // Amplitude of a mode in a channel at t_0, and its standard deviation, either component.
  [[nodiscard]] std::complex<double> amplitude(int channel, std::size_t mode) const noexcept;
  [[nodiscard]] double u_amplitude(int channel, std::size_t mode) const noexcept;

  // Covariance of (Re, Im) of that amplitude, the poles given.
  [[nodiscard]] Eigen::Matrix2d amplitude_covariance(int channel, std::size_t mode) const noexcept {
    return at(channel).solution.amplitude_covariance(static_cast<Eigen::Index>(mode));
  }

  // Whether the amplitude of a mode stands out of the noise in any channel.
  [[nodiscard]] bool shows(std::size_t mode) const noexcept;
  // Whether the amplitudes of all channels together are more than noise gives: at one given pole it does once in 10⁹.
  [[nodiscard]] bool certain(std::size_t mode) const noexcept;

  // What may be left of the transient from t on: the envelope of what stands out of the noise, and the standard
  // deviation of the whole. swing: what all modes together reach within half a cycle of the drive from t on, in the
  // channel's unit, as fitted: two modes that cancel each other have a large envelope and a small swing.
  struct Left {
    double envelope, u, swing;
  };
  [[nodiscard]] Left left(int channel, std::int64_t t_ns) const noexcept;

  // What mode m may at most be at t, three standard deviations included.
  [[nodiscard]] double most(int channel, std::size_t m, std::int64_t t_ns) const noexcept;
  // From t on mode m is as good as nothing: it costs no more until the next restart.
  void fade(std::size_t m, std::int64_t t_ns) noexcept { regressors_.fade(m, t_ns); }
  [[nodiscard]] std::int64_t faded_ns(std::size_t m) const noexcept { return regressors_.faded_ns(m); }

  // What the fit leaves of a reading, steady lines included in the fit.
  [[nodiscard]] double residual(int channel, std::int64_t t_ns, double value) noexcept;
  // The transient and the steady lines at t, in the channel's unit.
  [[nodiscard]] double disturbance(int channel, std::int64_t t_ns) noexcept;
  // B += (sin ωu, cos ωu)' (regressors of the modes, then their derivatives by the poles) at t: what an error of the
  // amplitudes and of the poles does to the steady phasor.
  void overlap_at(std::int64_t t_ns, Eigen::Matrix<double, 2, Eigen::Dynamic>& B) noexcept;
  // Covariance of (Σ sin ωu e, Σ cos ωu e), e the error of what is taken out: B Cov B', B from overlap_at.
  [[nodiscard]] Eigen::Matrix2d spread(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept;
  // (Σ sin ωu e, Σ cos ωu e), e what is taken out, B from overlap_at.
  [[nodiscard]] Eigen::Vector2d taken_out(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept;
  [[nodiscard]] int modal_regressors() const noexcept { return 4 * static_cast<int>(regressors_.motion().capacity()); }

 private:
  struct PerChannel {
    ModalSolution solution;
    PoleErrors::Effect errors;  // what those of the poles do to the solution
    // All that is known of the errors of the modal amplitudes: errors.whole, or what the solution alone tells.
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
  // What all modes together reach so many seconds after t0, as fitted, and its variance.
  struct Swing {
    double value, variance;
  };
  [[nodiscard]] Swing swing_at(const PerChannel& of, double u) const noexcept;
  // How many rows of channel.covariance() are of use.
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
