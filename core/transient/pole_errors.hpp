// Propagates the uncertainty of the poles and of ω to the modal amplitudes of each channel.
//
// η: relative errors of the poles (two each) and of ω. L: the linear regressors. D: the derivatives' regressors, J
// their coefficients. An error η adds D J η to the model, which shifts the linear parameters by -(L'L)^-1 L'D J η.
//
// Call begin(), add() for each channel, solve(), propagate() for each channel. All memory is allocated by the
// constructors. Bound to one thread; real-time safe.
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
  // most: capacity in poles.
  explicit PoleErrors(Eigen::Index most);

  // The effect of η on one channel.
  struct Effect {
    explicit Effect(Eigen::Index most) : by_poles(4 * most, 2 * most + 1), whole(4 * most, 4 * most) {}
    Eigen::MatrixXd by_poles;  // derivative by η: of the modal amplitudes, then of the derivatives' coefficients
    Eigen::MatrixXd whole;     // covariance of these rows, the noise of the amplitudes included
    bool known = false;        // false: only the covariance of the solution is known
  };

  void begin(const ModalLayout& layout) noexcept;
  // Adds a solved channel, directly after linear.eliminate() for it. shows: per mode, whether it shows in any channel.
  void add(const ModalLayout& layout, const ModalMotion& motion, const ModalSolution& solution, LinearPart& linear,
           std::span<const bool> shows, Effect& effect) noexcept;
  // Computes the covariance of η from the channels added and a prior of width max(1/T, |Re λ|) on each pole, with T =
  // seen_s. omega_information: more of it about the relative error of ω. false: the information is singular.
  bool solve(const ModalLayout& layout, const ModalMotion& motion, double seen_s, double omega_information) noexcept;
  // After solve(), for a channel that was added: fills effect.whole.
  void propagate(const ModalLayout& layout, const ModalSolution& solution, Effect& effect) noexcept;

  [[nodiscard]] const Eigen::MatrixXd& covariance() const noexcept { return covariance_; }

 private:
  Eigen::MatrixXd information_, covariance_, products_;
};

}  // namespace dwell
