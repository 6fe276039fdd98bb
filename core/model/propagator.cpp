#include "core/model/propagator.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/model/state_matrix.hpp"

namespace dwell {
namespace {

constexpr int kMaxPowers = 52;       // mantissa bits of a double, which counts the steps τ
constexpr double kSmallNorm = 0.03;  // ‖A τ‖
constexpr int kTaylorTerms = 9;      // of exp(A τ); the remainder is below 0.03^10 / 10! < 1e-21
constexpr double kVanished = 1e-40;  // a transient reduced by this factor counts as zero

}  // namespace

Propagator::Propagator(const Chain& chain) {
  StateMatrix system = state_matrix(chain);
  A_ = std::move(system.A);
  scale_ = std::move(system.scale);
  const Eigen::Index size = A_.rows();
  x_.resize(size);
  term_.resize(size);
  if (size == 0) return;
  const double norm = std::max(A_.cwiseAbs().colwise().sum().maxCoeff(), 1e-300);
  tau_s_ = kSmallNorm / norm;

  Eigen::MatrixXd power = Eigen::MatrixXd::Identity(size, size);
  Eigen::MatrixXd term = power;
  for (int i = 1; i <= kTaylorTerms; ++i) {
    term = (A_ * term * (tau_s_ / i)).eval();
    power += term;
  }
  for (int k = 0; k < kMaxPowers; ++k) {
    powers_.push_back(power);
    power = (power * power).eval();
    if (power.cwiseAbs().maxCoeff() < kVanished) {
      vanishes_ = true;
      break;
    }
  }
}

void Propagator::small_step(double dt_s) {
  term_ = x_;
  for (int i = 1; i <= kTaylorTerms; ++i) {
    product_.noalias() = A_ * term_;
    term_ = product_ * (dt_s / i);
    x_ += term_;
  }
}

void Propagator::apply(double dt_s, Eigen::VectorXd& state) {
  assert(dt_s >= 0.0 && state.size() == A_.rows());
  if (A_.rows() == 0) return;
  x_ = state.cwiseProduct(scale_);
  const double steps = std::floor(dt_s / tau_s_);
  small_step(std::max(0.0, std::fma(-steps, tau_s_, dt_s)));
  const double beyond = std::ldexp(1.0, static_cast<int>(powers_.size()));
  if (steps >= beyond) {
    // Longer than the table of powers: the transient has vanished, or a double cannot count so many steps τ.
    state.setConstant(vanishes_ ? 0.0 : std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const auto bits = static_cast<std::uint64_t>(steps);
  for (std::size_t k = 0; k < powers_.size(); ++k)
    if ((bits >> k & 1U) != 0) {
      product_.noalias() = powers_[k] * x_;
      x_.swap(product_);
    }
  state = x_.cwiseQuotient(scale_);
}

}  // namespace dwell
