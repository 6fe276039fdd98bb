// The half of a Kalman filter that does not see the readings: covariance of the state, gain and variance of each
// innovation, with derivatives by the unknowns.
//
//   P- = F P F' + q Q;   S = C P C' + σ²,   K = P C' / S,   P+ = M P M' + K σ² K',  M = I - K C   (Joseph's form)
//   ∂P+ = M ∂P M' + K ∂σ² K' - M P ∂C' K' - (…)'          (∂K drops out: K makes P+ least)
//
// The filter starts with P = 0: the initial state is known in it, and unknown in the likelihood, where it is one of the
// unknowns (core/motion/likelihood.hpp). So nothing is large at the start, and nothing cancels.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/interval_steps.hpp"
#include "core/motion/motion_model.hpp"

namespace dwell {

// What one reading does. p parameters, m states.
struct KalmanGain {
  double S = 0.0;      // variance of the innovation
  double noise = 0.0;  // σ²: the variance of the reading's own noise, a part of S
  Eigen::VectorXd K;   // m
  Eigen::VectorXd dS;  // p
  Eigen::MatrixXd dK;  // m × p
};

class CovarianceFilter {
 public:
  // All must outlive it. derivatives: false leaves dS and dK empty.
  CovarianceFilter(const MotionModel& model, const LinearModel& linear, const Eigen::VectorXd& theta, bool derivatives);

  // Over an interval in the given stretch.
  void propagate(const Step& step, const std::vector<int>& derivative_of, int stretch);
  // A reading of channel c: its gain into `out`, P to after it.
  void take(int c, KalmanGain& out);
  [[nodiscard]] const Eigen::MatrixXd& P() const noexcept { return P_; }

 private:
  void take_derivatives(int c, const Eigen::VectorXd& g, KalmanGain& out);

  const LinearModel& linear_;
  std::vector<Parameter> parameters_;
  std::vector<double> intensity_, variance_;  // per stretch, per channel
  bool derivatives_;
  Eigen::MatrixXd P_;
  std::vector<Eigen::MatrixXd> dP_;
  Eigen::MatrixXd FP_, half_;
  Eigen::VectorXd g_, dg_, MPdC_;
};

}  // namespace dwell
