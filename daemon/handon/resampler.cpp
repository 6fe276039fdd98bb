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
// Keeps the equations solvable where readings tell the same. 1e-6 makes errors of 5e-5; with 1e-11 rounding shows.
constexpr double kRidge = 1e-9;
constexpr std::uint64_t kReadingsPerCheck = 16;

double sinc(double angle) noexcept { return std::fabs(angle) < 1e-9 ? 1.0 : std::sin(angle) / angle; }

}  // namespace

double Resampler::Check::rms() const noexcept {
  return count == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(count));
}

void Resampler::begin(std::int64_t first_ns) noexcept {
  next_ns_ = first_ns;
  count_ = 0;
}

std::int64_t Resampler::after_ns() const noexcept { return t_ns_[(count_ - N / 2) % N]; }

double Resampler::angle(std::int64_t t_ns) const noexcept {
  const std::int64_t oldest_ns = t_ns_[count_ % N];
  return 2.0 * std::numbers::pi * kBand * static_cast<double>(t_ns - oldest_ns) / interval_ns_;
}

bool Resampler::add(std::int64_t t_ns, double x) {
  const auto place = static_cast<std::size_t>(count_ % N);
  t_ns_[place] = t_ns;
  x_[place] = x;
  ++count_;
  if (count_ < N) return false;
  const bool check = count_ % kReadingsPerCheck == 0;
  const bool needed = next_ns_ < after_ns();
  if (needed || check) solve(check);
  return needed;
}

void Resampler::solve(bool check) {
  mean_ = std::accumulate(x_.begin(), x_.end(), 0.0) / N;
  Eigen::Array<double, N, 1> phi, sine, cosine;
  for (int i = 0; i < N; ++i) {
    phi[i] = angle(t_ns_[static_cast<std::size_t>(i)]);
    sine[i] = std::sin(phi[i]);
    cosine[i] = std::cos(phi[i]);
  }
  Eigen::Matrix<double, N, N> K;
  for (int j = 0; j < N; ++j) {
    K(j, j) = 1.0 + kRidge;
    for (int i = j + 1; i < N; ++i) {
      const double apart = phi[i] - phi[j];
      // sin(φi - φj) from the sines and cosines of both: 32 of each instead of 496.
      K(i, j) = std::fabs(apart) < 1e-9 ? 1.0 : (sine[i] * cosine[j] - cosine[i] * sine[j]) / apart;
    }
  }
  const Eigen::LLT<Eigen::Ref<Eigen::Matrix<double, N, N>>> factor(K);  // in place: reads the lower half
  Eigen::Map<Eigen::Matrix<double, N, 1>> weight(weight_.data());
  weight = (Eigen::Map<const Eigen::Array<double, N, 1>>(x_.data()) - mean_).matrix();
  factor.solveInPlace(weight);
  if (!check) return;
  // Without reading i its estimate is off by weight_i / (K⁻¹)_ii.
  const auto middle = static_cast<Eigen::Index>((count_ - N / 2) % N);
  Eigen::Matrix<double, N, 1> column = Eigen::Matrix<double, N, 1>::Unit(middle);
  factor.matrixL().solveInPlace(column);
  const double off = weight[middle] / column.squaredNorm();
  check_.sum_of_squares += off * off;
  check_.largest = std::max(check_.largest, std::fabs(off));
  ++check_.count;
}

double Resampler::value_at(std::int64_t t_ns) const noexcept {
  const double here = angle(t_ns);
  double y = mean_;
  for (std::size_t i = 0; i < N; ++i) y += sinc(here - angle(t_ns_[i])) * weight_[i];
  return y;
}

}  // namespace dwell::handon
