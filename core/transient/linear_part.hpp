// The linear parameters of the modal fit: solved, or eliminated so that poles and ω remain (Golub and Pereyra's
// variable projection).
//
// L: the regressors of the linear parameters; D: the derivatives beside them. All memory is allocated by the
// constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>

#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"
#include "core/transient/modal_solution.hpp"
#include "core/transient/modal_sums.hpp"

namespace dwell {

class LinearPart {
 public:
  // most: as many modes at most.
  LinearPart(int harmonics, Eigen::Index most);

  // Solves one channel, whose sums are complete; its `sigma2` is what the noise is taken to be first. range,
  // line_range: widths of the prior of the amplitudes of what decays and of steady lines, in its unit. false: too few
  // samples.
  bool solve(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, double range,
             double line_range, ModalSolution& of) noexcept;

  // Eliminates the linear parameters of one channel. prior, line_prior: information of the amplitudes' priors, times
  // σ². false: the channel cannot be solved.
  bool eliminate(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, double prior,
                 double line_prior) noexcept;
  // After that: S = D'D - D'L (L'L)^-1 L'D, what the derivatives explain beyond the linear parameters.
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> beyond(const ModalLayout& layout) const noexcept {
    return slopes_.topLeftCorner(layout.slopes(), layout.slopes());
  }
  // (L'L)^-1 L'D: by how much the linear parameters take over what the derivatives explain. Once after eliminate().
  [[nodiscard]] Eigen::Block<const Eigen::MatrixXd> taken_over(const ModalLayout& layout) noexcept;

 private:
  // L'L with the priors, into work_.
  Eigen::Block<Eigen::MatrixXd> weighed(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums,
                                        double prior, double line_prior) noexcept;

  Eigen::MatrixXd work_, columns_, slopes_;
  Eigen::VectorXd product_;
};

}  // namespace dwell
