// One Gauss-Newton step on the poles of the modal fit and on ω, from all its channels, with all linear parameters
// eliminated (variable projection as simplified by Kaufman).
//
// begin(), add() each channel, take(). All memory is allocated by the constructor. Bound to one thread; real-time safe.
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
  // most: as many poles at most.
  explicit PoleStep(Eigen::Index most);

  void begin(const ModalLayout& layout) noexcept;
  // A solved channel. S: what the derivatives explain beyond the linear parameters, LinearPart::beyond().
  void add(const ModalLayout& layout, const ModalMotion& motion, const ModalSums& sums, const ModalSolution& solution,
           const Eigen::Block<const Eigen::MatrixXd>& S) noexcept;
  // Steps within `trust` of each pole's magnitude and `trust_omega` of ω (0: it is known). stated: of ω.
  void take(const ModalLayout& layout, const ModalMotion& motion, const FrequencyPrior& stated, double trust,
            double trust_omega) noexcept;

  // Where the step leads: the poles, and ω, rad/s.
  [[nodiscard]] const std::vector<std::complex<double>>& poles() const noexcept { return poles_; }
  [[nodiscard]] double omega() const noexcept { return omega_; }
  // How far it went, in standard deviations of the poles and of ω.
  [[nodiscard]] double length() const noexcept { return length_; }
  // Standard uncertainty of a pole, rad/s, either component.
  [[nodiscard]] double u_pole(std::size_t m) const noexcept { return u_poles_[m]; }
  // Covariance of (Re, Im) of the relative change of a pole, from the data alone.
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

  // Of the relative changes of the poles (two each), then of that of ω: score and information; a scratch of their size
  // (an even number of rows keeps its columns aligned); their covariance.
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd hessian_, inverse_, covariance_;
  std::vector<std::complex<double>> poles_;
  std::vector<double> u_poles_, disagreement_;
  double omega_ = 0.0, length_ = 0.0;
};

}  // namespace dwell
