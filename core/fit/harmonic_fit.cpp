#include "core/fit/harmonic_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

namespace dwell {
namespace {

// Σ u^j cos kθ and Σ u^j sin kθ, k of either sign.
struct Instants {
  const double* set;
  int count;
  [[nodiscard]] double c(int j, int k) const noexcept { return set[moments::cosine(count, j, std::abs(k))]; }
  [[nodiscard]] double s(int j, int k) const noexcept {
    const double value = set[moments::sine(count, j, std::abs(k))];
    return k < 0 ? -value : value;
  }
  // Σ u^j times the product of two regressors, from the sum and the difference of their angles.
  [[nodiscard]] double sin_sin(int j, int h, int l) const noexcept { return 0.5 * (c(j, h - l) - c(j, h + l)); }
  [[nodiscard]] double cos_cos(int j, int h, int l) const noexcept { return 0.5 * (c(j, h - l) + c(j, h + l)); }
  [[nodiscard]] double sin_cos(int j, int h, int l) const noexcept { return 0.5 * (s(j, h + l) + s(j, h - l)); }
};

// Information matrix R of the harmonic fit, lower triangle. Order of the parameters: b, p_1 … p_H, q_1 … q_H.
template <class Matrix>
void assemble(const Instants& M, int H, Matrix& R) noexcept {
  R(0, 0) = M.c(0, 0);
  for (int h = 1; h <= H; ++h) {
    R(h, 0) = M.s(0, h);
    R(H + h, 0) = M.c(0, h);
    for (int l = 1; l <= H; ++l) {
      if (l <= h) R(h, l) = M.sin_sin(0, h, l);
      R(H + h, l) = M.sin_cos(0, l, h);
      if (l <= h) R(H + h, H + l) = M.cos_cos(0, h, l);
    }
  }
}

}  // namespace

HarmonicFits::HarmonicFits(const Totals& totals, int harmonics) noexcept
    : totals_(totals), harmonics_(harmonics), factor_(2 * harmonics + 1) {
  assert(harmonics <= totals.harmonics());
}

void HarmonicFits::take(const double* instants) noexcept {
  if (instants == instants_) return;
  instants_ = instants;
  const int parameters = 2 * harmonics_ + 1;
  Matrix R(parameters, parameters);
  assemble(Instants{instants, 2 * totals_.harmonics() + 1}, harmonics_, R);
  factor_.compute(R);
  // A pivot is the energy of a regressor that the regressors before it do not explain. Below a thousandth, the
  // regressor cannot be told from the others.
  solvable_ = factor_.info() == Eigen::Success && factor_.vectorD().minCoeff() > 1e-3 * instants[0];
  has_columns_ = false;
}

HarmonicFit HarmonicFits::fit(int channel, double reference) noexcept {
  HarmonicFit fit;
  const ChannelMoments sums = totals_.channel(channel);
  const int H = harmonics_, parameters = 2 * H + 1, in_set = totals_.harmonics() + 1;
  const Instants M{sums.instants, 2 * totals_.harmonics() + 1};
  const double* Z = sums.readings;
  const double sum_squares = Z[moments::squares(in_set)];
  fit.samples = M.c(0, 0);
  if (fit.samples < parameters + 1) return fit;

  take(sums.instants);
  if (!solvable_) return fit;
  Vector z(parameters);
  z(0) = Z[moments::cosine(in_set, 0, 0)];
  for (int h = 1; h <= H; ++h) {
    z(h) = Z[moments::sine(in_set, 0, h)];
    z(H + h) = Z[moments::cosine(in_set, 0, h)];
  }
  const Vector theta = factor_.solve(z);

  // A difference below 1e-15 of the sum is rounding.
  const double squares = std::max(sum_squares - theta.dot(z), 1e-15 * sum_squares);
  fit.sigma2 = squares / (fit.samples - parameters);
  if (!has_columns_) {
    Columns unit(parameters, 2);
    unit.setZero();
    unit(1, 0) = unit(H + 1, 1) = 1.0;
    columns_ = factor_.solve(unit);
    has_columns_ = true;
  }
  fit.covariance << columns_(1, 0), columns_(1, 1), columns_(H + 1, 0), columns_(H + 1, 1);
  fit.covariance *= fit.sigma2;
  fit.mean = theta(0) + reference;
  for (int h = 1; h <= H; ++h) fit.X[static_cast<std::size_t>(h - 1)] = {theta(h), theta(H + h)};
  fit.usable = theta.allFinite() && fit.covariance.allFinite();
  if (!fit.usable) return fit;

  // ∂s/∂ω = g = u Σ_h h (p_h cos hθ - q_h sin hθ), gX = Xᵀg, gs = gᵀs. gg = ½ Σ h²|X_h|² Σu² is the part of gᵀg that
  // does not oscillate; its relative error is 1 / (number of periods)².
  Vector gX = Vector::Zero(parameters);
  double gg = 0.0, gs = 0.0;
  for (int h = 1; h <= H; ++h) {
    const double p = h * theta(h), q = h * theta(H + h);
    gs += p * Z[moments::cosine(in_set, 1, h)] - q * Z[moments::sine(in_set, 1, h)];
    gg += 0.5 * (p * p + q * q) * sums.instants[moments::squares(M.count)];
    gX(0) += p * M.c(1, h) - q * M.s(1, h);
    for (int l = 1; l <= H; ++l) {
      gX(l) += p * M.sin_cos(1, l, h) - q * M.sin_sin(1, l, h);
      gX(H + l) += p * M.cos_cos(1, l, h) - q * M.sin_cos(1, h, l);
    }
  }
  const Vector explained = factor_.solve(gX);
  const double curvature = gg - gX.dot(explained);
  if (fit.sigma2 > 0 && curvature > 0) {
    fit.score = (gs - gX.dot(theta)) / fit.sigma2;
    fit.information = curvature / fit.sigma2;
  }
  return fit;
}

HarmonicFit fit_harmonics(const Totals& totals, int channel, int harmonics, double reference) noexcept {
  return HarmonicFits(totals, harmonics).fit(channel, reference);
}

PhasorSlope HarmonicFits::slope(int channel, const HarmonicFit& fit, double reference) noexcept {
  PhasorSlope slope;
  if (!fit.usable) return slope;
  const ChannelMoments sums = totals_.channel(channel);
  const int H = harmonics_, parameters = 2 * H + 1, in_set = totals_.harmonics() + 1;
  const Instants M{sums.instants, 2 * totals_.harmonics() + 1};
  take(sums.instants);
  Vector theta(parameters);
  theta(0) = fit.mean - reference;
  for (int h = 1; h <= H; ++h) {
    theta(h) = fit.X[static_cast<std::size_t>(h - 1)].real();
    theta(H + h) = fit.X[static_cast<std::size_t>(h - 1)].imag();
  }
  // G: products of the regressors u sin θ and u cos θ with those of the fit.
  Columns G(parameters, 2);
  G.row(0) << M.s(1, 1), M.c(1, 1);
  for (int l = 1; l <= H; ++l) {
    G.row(l) << M.sin_sin(1, 1, l), M.sin_cos(1, l, 1);
    G.row(H + l) << M.sin_cos(1, 1, l), M.cos_cos(1, 1, l);
  }
  const double square = 0.5 * sums.instants[moments::squares(M.count)];
  const Columns explained = factor_.solve(G);
  const Eigen::Matrix2d S = square * Eigen::Matrix2d::Identity() - G.transpose() * explained;
  const Eigen::Vector2d score =
      Eigen::Vector2d(sums.readings[moments::sine(in_set, 1, 1)], sums.readings[moments::cosine(in_set, 1, 1)]) -
      G.transpose() * theta;
  const double determinant = S.determinant();
  // If the fit leaves less than about a tenth of Σu²/2 unexplained, no slope can be told.
  if (!(determinant > 0.01 * square * square)) return slope;
  const Eigen::Matrix2d inverse = S.inverse();
  const Eigen::Vector2d value = inverse * score;
  slope.value = {value(0), value(1)};
  slope.variance = fit.sigma2 * inverse.trace();
  return slope;
}

}  // namespace dwell
