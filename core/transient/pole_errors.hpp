// What is not known of the poles and of ω, and what that does to the amplitudes of each channel.
//
// η: relative errors of the poles (two each) and of ω. L: the linear regressors. D: the regressors' derivatives, J
// their coefficients, so that η adds D J η to the model. Then η shifts the linear amplitudes by -(L'L)^-1 L'D J η.
//
// begin(), add() each channel, solve(), propagate() to each channel. All memory is allocated by the constructors. Bound
// to one thread; real-time safe.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/transient/linear_part.hpp"
#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"
#include "core/transient/modal_solution.hpp"

namespace dwell {

class PoleErrors {
 public:
  // most: as many poles at most.
  explicit PoleErrors(Eigen::Index most);

  // What η does to one channel.
  struct Effect {
    explicit Effect(Eigen::Index most) : by_poles(4 * most, 2 * most + 1), whole(4 * most, 4 * most) {}
    Eigen::MatrixXd by_poles;  // by η: the modal amplitudes, then the coefficients of the modes' derivatives
    Eigen::MatrixXd whole;     // covariance of all these, the noise of the amplitudes included
    bool known = false;        // else the covariance of the solution is all that is known
  };

  void begin(const ModalLayout& layout) noexcept;
  // A solved channel whose linear parameters were just eliminated. shows: per mode, whether it does in any channel.
  void add(const ModalLayout& layout, const ModalMotion& motion, const ModalSolution& solution, LinearPart& linear,
           std::span<const bool> shows, Effect& effect) noexcept;
  // The covariance of η, by what was added and by a prior of max(1/T, |Re λ|) on each pole, T = seen_s the time seen.
  // omega_information: of ω, from elsewhere, per relative change squared. false: there is none.
  bool solve(const ModalLayout& layout, const ModalMotion& motion, double seen_s, double omega_information) noexcept;
  // After that, for a channel that was added.
  void propagate(const ModalLayout& layout, const ModalSolution& solution, Effect& effect) noexcept;

  [[nodiscard]] const Eigen::MatrixXd& covariance() const noexcept { return covariance_; }

 private:
  Eigen::MatrixXd information_, covariance_, products_;
};

}  // namespace dwell
