#include "core/rig/usable_observation.hpp"

#include <cmath>

namespace dwell {
namespace {

// Ridge on the diagonal of G'G, relative to its largest entry, so that the Cholesky factor exists. An unknown that no
// channel shows rests on it alone. Entries of G are 0 and ±1, so determined directions have eigenvalues above 1/(4n²).
constexpr double kRidge = 1e-12;
constexpr double kDetermined = 1e-6;  // largest part of an unknown that may rest on the ridge

}  // namespace

UsableObservation::UsableObservation(const Rig& rig, const Eigen::MatrixXd& G)
    : G_(G),
      normal_(G.cols(), G.cols()),
      inverse_(G.cols(), G.cols()),
      uses_(Eigen::VectorXd::Zero(G.rows())),
      observed_(Eigen::VectorXcd::Zero(G.rows())),
      right_(G.cols()),
      unknowns_(rig.boundary == Boundary::clamped ? G.cols() : G.cols() - 1) {}

void UsableObservation::leave_out(int c) noexcept { uses_(c) = 0.0; }

void UsableObservation::observe(int c, std::complex<double> o) noexcept {
  uses_(c) = 1.0;
  observed_(c) = o;
}

bool UsableObservation::solve(Eigen::Ref<Eigen::VectorXcd> x) noexcept {
  normal_.setZero();
  right_.setZero();
  for (Eigen::Index c = 0; c < G_.rows(); ++c) {
    if (uses_(c) == 0) continue;
    normal_.noalias() += G_.row(c).transpose().lazyProduct(G_.row(c));
    right_ += G_.row(c).transpose() * observed_(c);
  }
  const double ridge = kRidge * std::max(1.0, normal_.diagonal().maxCoeff());
  normal_.diagonal().array() += ridge;
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(normal_);
  if (llt.info() != Eigen::Success) return false;
  inverse_.setIdentity();
  llt.solveInPlace(inverse_);
  for (Eigen::Index i = 0; i < unknowns_; ++i)
    if (ridge * inverse_(i, i) > kDetermined) return false;
  x.noalias() = inverse_.lazyProduct(right_);
  return x.allFinite();
}

}  // namespace dwell
