#include "core/motion/covariance_filter.hpp"

#include <cmath>

namespace dwell {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

CovarianceFilter::CovarianceFilter(const MotionModel& model, const LinearModel& linear, const VectorXd& theta,
                                   bool derivatives)
    : linear_(linear), parameters_(model.parameters()), derivatives_(derivatives) {
  variance_.assign(model.rig().channels.size(), 0.0);
  for (std::size_t a = 0; a < parameters_.size(); ++a) {
    const Parameter& p = parameters_[a];
    const double value = theta(static_cast<Index>(a));
    const auto i = static_cast<std::size_t>(p.index);
    if (p.what == Unknown::noise) variance_[i] = std::exp(2 * value);
    if (p.what == Unknown::intensity) {
      if (intensity_.size() <= i) intensity_.resize(i + 1, 0.0);
      intensity_[i] = std::exp(value);
    }
  }
  P_ = MatrixXd::Zero(model.states(), model.states());
  if (derivatives_) dP_.assign(parameters_.size(), P_);
}

void CovarianceFilter::propagate(const Step& step, const std::vector<int>& derivative_of, int stretch) {
  const double q = intensity_[static_cast<std::size_t>(stretch)];
  FP_.noalias() = step.F().lazyProduct(P_);
  for (std::size_t a = 0; a < dP_.size(); ++a) {
    if (is_input(parameters_[a].what)) continue;  // no covariance depends on it
    MatrixXd& dP = dP_[a];
    half_.noalias() = dP.lazyProduct(step.F().transpose());
    dP.noalias() = step.F().lazyProduct(half_);
    if (const int d = derivative_of[a]; d >= 0) {
      half_.noalias() = step.dF(d).lazyProduct(FP_.transpose());
      dP += half_ + half_.transpose() + q * step.dQ(d);
    }
    if (parameters_[a].what == Unknown::intensity && parameters_[a].index == stretch) dP += q * step.Q();
  }
  P_.noalias() = FP_.lazyProduct(step.F().transpose());
  P_ += q * step.Q();
  P_.triangularView<Eigen::StrictlyUpper>() = P_.transpose();  // what rounding makes of symmetry would grow
}

void CovarianceFilter::take(int c, KalmanGain& out) {
  const auto C = linear_.C.row(c);
  const double variance = variance_[static_cast<std::size_t>(c)];
  g_.noalias() = P_.lazyProduct(C.transpose());
  out.S = C.transpose().dot(g_) + variance;
  out.noise = variance;
  out.K = g_ / out.S;
  if (derivatives_) take_derivatives(c, g_, out);
  // M P M' + K σ² K' with M P M' = P - K g' - g K' + K (C g) K'.
  P_.noalias() -= out.K * g_.transpose();
  P_.noalias() -= g_ * out.K.transpose();
  P_.noalias() += out.S * out.K * out.K.transpose();
}

void CovarianceFilter::take_derivatives(int c, const VectorXd& g, KalmanGain& out) {
  const auto C = linear_.C.row(c);
  const double variance = variance_[static_cast<std::size_t>(c)];
  const auto p = static_cast<Index>(parameters_.size());
  out.dS.resize(p);
  out.dK.resize(g.size(), p);
  for (Index a = 0; a < p; ++a) {
    MatrixXd& dP = dP_[static_cast<std::size_t>(a)];
    const Parameter& of = parameters_[static_cast<std::size_t>(a)];
    if (is_input(of.what)) {
      out.dS(a) = 0.0;
      out.dK.col(a).setZero();
      continue;
    }
    const double d_variance = of.what == Unknown::noise && of.index == c ? 2 * variance : 0.0;
    const MatrixXd& dC = linear_.dC[static_cast<std::size_t>(a)];
    dg_.noalias() = dP.lazyProduct(C.transpose());
    const double CdPC = C.transpose().dot(dg_);
    double dS = CdPC + d_variance;
    dP.noalias() -= out.K * dg_.transpose();
    dP.noalias() -= dg_ * out.K.transpose();
    dP.noalias() += (CdPC + d_variance) * out.K * out.K.transpose();
    if (dC.size() > 0) {
      MPdC_.noalias() = P_.lazyProduct(dC.row(c).transpose());
      const double dCg = dC.row(c).transpose().dot(g);
      dS += 2 * dCg;
      dg_ += MPdC_;
      MPdC_ -= out.K * dCg;  // M P dC'
      dP.noalias() -= MPdC_ * out.K.transpose();
      dP.noalias() -= out.K * MPdC_.transpose();
    }
    out.dS(a) = dS;
    out.dK.col(a) = (dg_ - out.K * dS) / out.S;
  }
}

}  // namespace dwell
