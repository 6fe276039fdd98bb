#include "daemon/handon/resampler.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace dwell::handon {
namespace {

constexpr int N = Resampler::kReadings;
// Keeps the equations solvable if readings are nearly at one instant. 1e-6 makes errors of 5e-5; with 1e-11 rounding
// shows.
constexpr double kRidge = 1e-9;
constexpr std::uint64_t kReadingsPerCheck = 16;

// sinc(a - b), from the sines and cosines of both.
double sinc(double a, double sin_a, double cos_a, double b, double sin_b, double cos_b) noexcept {
  const double apart = a - b;
  return std::fabs(apart) < 1e-9 ? 1.0 : (sin_a * cos_b - cos_a * sin_b) / apart;
}

using Square = Eigen::Matrix<double, N, N>;
using Vector = Eigen::Matrix<double, N, 1>;

double sum(const SharedInstants::Values& x) { return std::accumulate(x.begin(), x.end(), 0.0); }

}  // namespace

void SharedInstants::take(const Instants& t_ns, std::size_t oldest, double interval_ns) {
  if (interval_ns == interval_ns_ && t_ns == t_ns_) return;
  t_ns_ = t_ns;
  interval_ns_ = interval_ns;
  oldest_ns_ = t_ns[oldest];
  at_ns_ = INT64_MIN;
  for (std::size_t i = 0; i < N; ++i) {
    angles_[i] = angle(t_ns[i]);
    sines_[i] = std::sin(angles_[i]);
    cosines_[i] = std::cos(angles_[i]);
  }
  Eigen::Map<Square> K(factor_.data());
  for (std::size_t j = 0; j < N; ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    K(column, column) = 1.0 + kRidge;
    for (std::size_t i = j + 1; i < N; ++i)
      K(static_cast<Eigen::Index>(i), column) =
          sinc(angles_[i], sines_[i], cosines_[i], angles_[j], sines_[j], cosines_[j]);
  }
  const Eigen::LLT<Eigen::Ref<Square>> in_place(K);  // reads the lower half and leaves the factor there
}

void SharedInstants::solve(Values& x) const {
  const Eigen::Map<const Square> factor(factor_.data());
  Eigen::Map<Vector> unknown(x.data());
  factor.triangularView<Eigen::Lower>().solveInPlace(unknown);
  factor.triangularView<Eigen::Lower>().transpose().solveInPlace(unknown);
}

double SharedInstants::inverse_at(std::size_t place) const {
  Vector column = Vector::Unit(static_cast<Eigen::Index>(place));
  Eigen::Map<const Square>(factor_.data()).triangularView<Eigen::Lower>().solveInPlace(column);
  return column.squaredNorm();
}

const SharedInstants::Values& SharedInstants::covariance(std::int64_t at_ns) {
  if (at_ns != at_ns_) {
    at_ns_ = at_ns;
    const double here = angle(at_ns), sine = std::sin(here), cosine = std::cos(here);
    for (std::size_t i = 0; i < N; ++i) covariance_[i] = sinc(here, sine, cosine, angles_[i], sines_[i], cosines_[i]);
  }
  return covariance_;
}

double SharedInstants::angle(std::int64_t at_ns) const noexcept {
  return 2.0 * std::numbers::pi * Resampler::kBand * static_cast<double>(at_ns - oldest_ns_) / interval_ns_;
}

double Resampler::Check::rms() const noexcept {
  return count == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(count));
}

void Resampler::begin(std::int64_t first_ns) noexcept {
  next_ns_ = first_ns;
  count_ = 0;
}

std::int64_t Resampler::behind_middle_ns(int further) const noexcept {
  return t_ns_[(count_ - static_cast<std::uint64_t>(N / 2 - further)) % N];
}

bool Resampler::add(SharedInstants& shared, std::int64_t t_ns, double x) {
  const auto place = static_cast<std::size_t>(count_ % N);
  t_ns_[place] = t_ns;
  x_[place] = x;
  ++count_;
  if (count_ < N) return false;
  const bool check = count_ % kReadingsPerCheck == 0;
  const bool needed = next_ns_ < behind_middle_ns(0);
  if (needed || check) solve(shared, check);
  return needed;
}

void Resampler::solve(SharedInstants& shared, bool check) {
  shared.take(t_ns_, static_cast<std::size_t>(count_ % N), interval_ns_);
  mean_ = sum(x_) / N;
  std::transform(x_.begin(), x_.end(), weight_.begin(), [this](double x) { return x - mean_; });
  shared.solve(weight_);
  if (!check) return;
  // Leaving reading i out, its estimate differs from it by weight_i / (K⁻¹)_ii.
  const auto middle = static_cast<std::size_t>((count_ - N / 2) % N);
  const double off = weight_[middle] / shared.inverse_at(middle);
  check_.sum_of_squares += off * off;
  check_.largest = std::max(check_.largest, std::fabs(off));
  ++check_.count;
}

double Resampler::value_at(SharedInstants& shared, std::int64_t t_ns) const {
  const SharedInstants::Values& k = shared.covariance(t_ns);
  return std::inner_product(k.begin(), k.end(), weight_.begin(), mean_);
}

}  // namespace dwell::handon
