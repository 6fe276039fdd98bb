#include "core/intake/motion_predictor.hpp"

#include <cmath>

#include "core/fit/moments.hpp"

namespace dwell {

MotionPredictor::Prediction MotionPredictor::predict(std::int64_t t_ns, std::int64_t before_ns, double omega) noexcept {
  if (held_ < kPoints) return {};
  const bool evenly = even_ >= kPoints - 1 && t_ns - points_.back().t_ns == gap_ns_;
  if (!evenly || gap_ns_ != weights_.gap_ns || omega != weights_.omega) {
    weights_.gap_ns = evenly ? gap_ns_ : 0;
    bool other = omega != weights_.omega;
    for (std::size_t j = 0; j < kPoints; ++j) {
      const std::int64_t ago_ns = points_[j].t_ns - t_ns;
      other |= ago_ns != weights_.ago_ns[j];
      weights_.ago_ns[j] = ago_ns;
    }
    if (other) weigh(omega);
  }
  if (!(weights_.gain > 0)) return {};
  // A reading that comes as soon after the one before as the points after each other comes after no pause.
  const bool no_pause = evenly && t_ns - before_ns == gap_ns_;
  if (!no_pause && 1e-9 * omega * static_cast<double>(t_ns - before_ns) > kPause * weights_.interval) return {};
  Prediction out;
  for (std::size_t j = 0; j < kPoints; ++j) out.value += weights_.of_point[j] * points_[j].value;
  out.gain = weights_.gain;
  return out;
}

double MotionPredictor::slope(const Prediction& predicted, std::int64_t t_ns) const noexcept {
  double steepest = 0.0;
  Point after{t_ns, predicted.value};
  for (std::size_t j = kPoints; j-- > 0; after = points_[j])
    steepest = std::max(steepest,
                        std::abs(after.value - points_[j].value) / static_cast<double>(after.t_ns - points_[j].t_ns));
  return 1e9 * steepest;
}

void MotionPredictor::weigh(double omega) noexcept {
  weights_.omega = omega;
  weights_.gain = 0.0;
  // Instants, rad. Their mean distance h scales the regressors 1, sin x / h, (1 - cos x) / h² to like sizes, however
  // dense the samples.
  std::array<double, kEven> x{}, s, c;
  for (std::size_t j = 0; j < kPoints; ++j) x[j] = 1e-9 * omega * static_cast<double>(weights_.ago_ns[j]);
  const double h = (x[kPoints - 1] - x[0]) / (kPoints - 1);
  if (!(h > 0) || h > kSparse || -x[kPoints - 1] > kBlind) return;
  weights_.interval = h;
  // Sine and cosine of half the angle: accurate for the smallest angles. A loop of its own, which the compiler
  // vectorizes.
  const double h2 = h * h;
  for (std::size_t j = 0; j < kEven; ++j) {
    double sine = 0.0, cosine = 0.0;
    moments::sin_cos(0.5 * x[j], sine, cosine);
    s[j] = 2 * sine * cosine / h;
    c[j] = 2 * sine * sine / h2;
  }
  double m01 = 0, m02 = 0, m11 = 0, m12 = 0, m22 = 0;
  for (std::size_t j = 0; j < kPoints; ++j) {
    m01 += s[j];
    m02 += c[j];
    m11 += s[j] * s[j];
    m12 += s[j] * c[j];
    m22 += c[j] * c[j];
  }
  // At the instant predicted the regressors are (1, 0, 0): the first column of the inverse gives the weights.
  const double m00 = kPoints;
  const double a00 = m11 * m22 - m12 * m12, a01 = m12 * m02 - m01 * m22, a02 = m01 * m12 - m11 * m02;
  const double determinant = m00 * a00 + m01 * a01 + m02 * a02;
  if (!(determinant > 1e-6 * m00 * m11 * m22)) return;
  for (std::size_t j = 0; j < kEven; ++j) weights_.of_point[j] = (a00 + a01 * s[j] + a02 * c[j]) / determinant;
  double squares = 1.0;
  for (std::size_t j = 0; j < kPoints; ++j) squares += weights_.of_point[j] * weights_.of_point[j];
  weights_.gain = std::sqrt(squares);
}

}  // namespace dwell
