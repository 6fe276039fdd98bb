#include "core/verify/verification_table.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Fewest periods of steady motion in which the harmonics and an offset can be separated.
constexpr double kFewestPeriods = 3.0;
// Quantile of the normal distribution beyond which a window's squares are not noise: one window in a hundred thousand,
// so that of a thousand windows all pass in 99 of 100 cases. A window that does not pass ends the steady part: at one
// in a thousand most long stretches would end early, and their table keep its noise. Twice it lets drifts of the
// noise's size pass.
constexpr double kQuantile = 4.26;

// Instants of the steady motion in a period: a spline through as many is off by 5e-6 of the amplitude.
constexpr double kDense = 30.0;

MatrixXd harmonics_at(const Instants& t_ns, Index from, double omega, int harmonics) {
  const auto count = static_cast<Index>(t_ns.size()) - from;
  MatrixXd out(count, 1 + 2 * harmonics);
  out.col(0).setOnes();
  for (Index i = 0; i < count; ++i) {
    const double angle = omega * to_s(t_ns[static_cast<std::size_t>(from + i)] - t_ns.back());
    for (int h = 1; h <= harmonics; ++h) {
      out(i, 2 * h - 1) = std::sin(h * angle);
      out(i, 2 * h) = std::cos(h * angle);
    }
  }
  return out;
}

// χ² of `count` degrees of freedom below that quantile, by Wilson and Hilferty (1931): with the few readings of a
// period its tail is far from a normal one.
bool is_noise(double squares, double count, double sigma) {
  const double part = 2 / (9 * count), root = 1 - part + kQuantile * std::sqrt(part);
  return squares <= sigma * sigma * count * root * root * root;
}

}  // namespace

SteadyTable::SteadyTable(const ChannelReadings& readings, double sigma, double omega, int harmonics)
    : from_(static_cast<Index>(readings.t_ns.size())), instants_(readings.t_ns) {
  const auto count = static_cast<Index>(readings.t_ns.size());
  const Eigen::Map<const VectorXd> value(readings.value.data(), count);
  const double span_s = count > 0 ? to_s(readings.t_ns.back() - readings.t_ns.front()) : 0.0;
  const double per_period = static_cast<double>(count) * kTwoPi / omega / std::max(span_s, 1e-9);
  const auto window = static_cast<Index>(std::max(4.0, std::ceil(per_period)));
  const auto fewest = static_cast<Index>(std::ceil(kFewestPeriods * per_period)) + 2 * (2 * harmonics + 1);
  if (count < fewest) return;
  // Compares the fit of the newest stretch of that length with ever earlier windows.
  const MatrixXd all = harmonics_at(readings.t_ns, 0, omega, harmonics);
  Index from = count - fewest;
  for (;;) {
    const VectorXd fitted = all.bottomRows(count - from).colPivHouseholderQr().solve(value.tail(count - from));
    const VectorXd left = value - all * fitted;
    if (!is_noise(left.tail(count - from).squaredNorm(), static_cast<double>(count - from), sigma)) return;
    Index begin = from;
    // Goes back at most by the fitted length: farther back the fit's own error is no longer small beside noise.
    const Index earliest = std::max<Index>(0, from - (count - from));
    while (begin - window >= earliest &&
           is_noise(left.segment(begin - window, window).squaredNorm(), static_cast<double>(window), sigma))
      begin -= window;
    if (begin == from) break;
    from = begin;
  }
  from_ = from;
  fit_ = all.bottomRows(count - from).completeOrthogonalDecomposition().pseudoInverse();
  const auto parts = static_cast<std::int64_t>(std::ceil(kDense / per_period));
  instants_.resize(static_cast<std::size_t>(from));
  for (auto i = static_cast<std::size_t>(from); i < readings.t_ns.size(); ++i) {
    for (std::int64_t part = 1; part < parts && i > static_cast<std::size_t>(from); ++part)
      instants_.push_back(readings.t_ns[i - 1] + (readings.t_ns[i] - readings.t_ns[i - 1]) * part / parts);
    instants_.push_back(readings.t_ns[i]);
  }
  dense_ = harmonics_at(instants_, from, omega, harmonics);
}

MatrixXd SteadyTable::apply(const MatrixXd& series) const {
  if (fit_.size() == 0) return series;
  MatrixXd out(series.rows(), from_ + dense_.rows());
  out.leftCols(from_) = series.leftCols(from_);
  out.rightCols(dense_.rows()) = (series.rightCols(fit_.cols()) * fit_.transpose()) * dense_.transpose();
  return out;
}

}  // namespace dwell
