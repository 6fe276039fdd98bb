// Solves the linear parameters of the modal fit, or eliminates them so that only poles and ω remain (Golub and
// Pereyra's variable projection).
//
// L: the regressors of the linear parameters, a row per sample. D: the derivatives by the poles and ω likewise. All
// memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>

#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"
#include "core/transient/modal_solution.hpp"
#include "core/transient/modal_sums.hpp"

namespace dwell {

class LinearPart {
 public:
  // most: capacity in modes.
  LinearPart(int harmonics, Eigen::Index most);

  // Solves one channel, whose sums are complete. of.sigma2 is the first guess of its noise variance. range, line_range:
  // standard deviations of the amplitudes' priors, for modes that decay and for steady lines, in the channel's unit.
  // false: too few samples, or the normal matrix is singular.
  bool solve(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, double range,
             double line_range, ModalSolution& of) noexcept;

  // Eliminates the linear parameters of one channel. prior, line_prior: information of the same priors, times σ².
  // false: the normal matrix is singular.
  bool eliminate(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, double prior,
                 double line_prior) noexcept;
  // After eliminate(): S = D'D - D'L (L'L)^-1 L'D, what the derivatives explain beyond the linear parameters.
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> beyond(const ModalLayout& layout) const noexcept {
    return slopes_.topLeftCorner(layout.slopes(), layout.slopes());
  }
  // (L'L)^-1 L'D: the linear parameters that fit the derivatives best. Call at most once after each eliminate().
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> taken_over(const ModalLayout& layout) noexcept;

 private:
  // Writes L'L with the priors into work_.
  Eigen::Block<Eigen::MatrixXd> weighed(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums,
                                        double prior, double line_prior) noexcept;

  Eigen::MatrixXd work_, columns_, slopes_;
  Eigen::VectorXd product_;
};

}  // namespace dwell
