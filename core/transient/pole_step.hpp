// Makes one Gauss-Newton step on the poles of the modal fit and on ω, from all its channels. The linear parameters are
// eliminated (variable projection as simplified by Kaufman).
//
// Call begin(), add() for each channel, take(). All memory is allocated by the constructor. Bound to one thread;
// real-time safe.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/fit/frequency_prior.hpp"
#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"
#include "core/transient/modal_solution.hpp"
#include "core/transient/modal_sums.hpp"

namespace dwell {

class PoleStep {
 public:
  // most: capacity in poles.
  explicit PoleStep(Eigen::Index most);

  void begin(const ModalLayout& layout) noexcept;
  // Adds a solved channel. S: LinearPart::beyond() of that channel.
  void add(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, const ModalSolution& solution,
           const Eigen::Block<const Eigen::MatrixXd>& S) noexcept;
  // Makes the step with Levenberg's damping: a Gaussian of width `trust` on the relative change of each pole, and of
  // `trust_omega` on that of ω (0: ω is known). A pole moves by 2 trust |λ| at most, ω by trust_omega ω at most.
  // stated: prior of ω. Where the information is singular, nothing moves.
  void take(const ModalLayout& layout, const ModalMotion& motion, const FrequencyPrior& stated, double trust,
            double trust_omega) noexcept;

  // Poles and ω after the step, rad/s.
  [[nodiscard]] const std::vector<std::complex<double>>& poles() const noexcept { return poles_; }
  [[nodiscard]] double omega() const noexcept { return omega_; }
  // The largest move of a pole or of ω in the step, in its standard deviations.
  [[nodiscard]] double length() const noexcept { return length_; }
  // Standard uncertainty of a pole, rad/s, either component, the damping included: trust |λ| at most.
  [[nodiscard]] double u_pole(std::size_t m) const noexcept { return u_poles_[m]; }
  // Covariance of (Re, Im) of the relative change of a pole without the damping; ModalMotion::kOpen bounds it.
  [[nodiscard]] Eigen::Matrix2d covariance(Eigen::Index m) const noexcept {
    return covariance_.block<2, 2>(2 * m, 2 * m);
  }
  // χ² of the channel that disagrees most with the common pole.
  [[nodiscard]] double disagreement(std::size_t m) const noexcept { return disagreement_[m]; }

 private:
  void note_disagreement(Eigen::Index m, const Eigen::Vector2d& score, Eigen::Matrix2d information) noexcept;
  void invert_information(const ModalLayout& layout) noexcept;
  void move(const ModalMotion& motion, std::size_t m, std::complex<double> rho, const Eigen::Vector2d& variances,
            double trust) noexcept;

  // For the relative changes of the poles (two each), then that of ω: score, information and covariance. inverse_ is
  // scratch; its even number of rows keeps its columns aligned.
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd hessian_, inverse_, covariance_;
  std::vector<std::complex<double>> poles_;
  std::vector<double> u_poles_, disagreement_;
  double omega_ = 0.0, length_ = 0.0;
};

}  // namespace dwell
