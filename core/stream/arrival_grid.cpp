#include "core/stream/arrival_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace dwell {
namespace {

constexpr std::size_t kFewestArrivals = 32;
constexpr double kUntold = 8.0;       // periods at the end in which a late reading cannot be told from a loss
constexpr double kLateClip = 3.0;     // periods: limits the weight of a stall in the choice of the period
constexpr double kResolution = 0.05;  // periods: smaller deviations earn no better cost
constexpr double kOutlier = 5.0;      // mean absolute deviations beyond which an arrival does not enter the fit
constexpr double kMostGaps = 0.25;

using Numbers = std::array<double, kLongestStretch>;

// Numbers the readings for a period. A reading counts as lost if all that follow are late by a whole period or more; a
// single late one is only late. Returns the smallest deviation, in periods, of an arrival from the grid through the
// first one.
double number_readings(std::span<const double> x_ns, double period_ns, Numbers& index) noexcept {
  const std::size_t n = x_ns.size();
  double later = 1e300;
  for (std::size_t j = n; j-- > 0;) {
    later = std::min(later, x_ns[j] / period_ns - static_cast<double>(j));
    index[j] = later;
  }
  const double earliest = later;
  // The last readings: a loss among them looks like lateness.
  std::size_t told = n - 1;
  for (double paced = 0.0; told > 0 && paced < kUntold; --told)
    paced += std::min(1.0, (x_ns[told] - x_ns[told - 1]) / period_ns);
  for (std::size_t j = told + 1; j < n; ++j) index[j] = index[told];
  for (std::size_t j = 0; j < n; ++j)
    index[j] = static_cast<double>(j) + std::max(0.0, std::floor(index[j] - earliest + 0.1));
  return earliest;
}

// Description length of the arrivals, per reading in nats: their scatter, plus kLossPrice for each loss.
double cost(std::span<const double> x_ns, double period_ns, Numbers& index) noexcept {
  const std::size_t n = x_ns.size();
  const double earliest = number_readings(x_ns, period_ns, index);
  double sum = 0.0, squares = 0.0;
  int losses = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const double late = std::min(x_ns[j] / period_ns - index[j] - earliest, kLateClip);
    sum += late;
    squares += late * late;
    if (j > 0 && index[j] - index[j - 1] > 1.5) ++losses;
  }
  const auto count = static_cast<double>(n);
  const double variance = std::max(0.0, squares / count - sum * sum / (count * count));
  return 0.5 * std::log(variance + kResolution * kResolution) + losses * kLossPrice / count;
}

double best_period(std::span<const double> x_ns, double nominal_ns, Numbers& index) noexcept {
  const auto steps = static_cast<double>(x_ns.size() - 1);
  const double mean_ns = x_ns.back() / steps;
  // Losses make the mean interval longer than the period. Jitter of the first and last arrival shifts it either way.
  const double low_ns = nominal_ns > 0.0 ? (1.0 - kNominalRange) * nominal_ns : 0.8 * mean_ns;
  const double high_ns = nominal_ns > 0.0 ? (1.0 + kNominalRange) * nominal_ns : (1.0 + 2.0 / steps) * mean_ns;
  const double step_ns = std::min(0.2 * low_ns / steps, high_ns - low_ns);
  double best_ns = 0.0, least = 1e300;
  const int tried = step_ns > 0 ? static_cast<int>((high_ns - low_ns) / step_ns) : 0;
  for (int i = 0; i <= tried; ++i) {
    const double period_ns = low_ns + i * step_ns;
    const double now = cost(x_ns, period_ns, index);
    if (now >= least) continue;
    least = now;
    best_ns = period_ns;
  }
  return best_ns;
}

struct GridLine {
  double period_ns, last_ns, spread;
};

// Least squares over the arrivals within `limit` periods of the line `before`.
GridLine fit(std::span<const double> x_ns, const Numbers& index, const GridLine& before, double limit) noexcept {
  const std::size_t n = x_ns.size();
  const double last = index[n - 1];
  double w = 0, k = 0, x = 0, kk = 0, kx = 0;
  const auto deviation = [&](std::size_t j, const GridLine& line) {
    return x_ns[j] - line.last_ns - (index[j] - last) * line.period_ns;
  };
  for (std::size_t j = 0; j < n; ++j) {
    if (std::abs(deviation(j, before)) > limit * before.period_ns) continue;
    const double at = index[j] - last;
    w += 1;
    k += at;
    x += x_ns[j];
    kk += at * at;
    kx += at * x_ns[j];
  }
  const double determinant = w * kk - k * k;
  if (!(determinant > 0)) return before;
  GridLine line{(w * kx - k * x) / determinant, (kk * x - k * kx) / determinant, 0.0};
  double sum = 0, count = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const double off = std::abs(deviation(j, line)) / line.period_ns;
    if (off > limit) continue;
    sum += off;
    count += 1;
  }
  line.spread = count > 0 ? sum / count : before.spread;
  return line;
}

}  // namespace

std::optional<ArrivalGrid> find_grid(std::span<const std::int64_t> arrivals_ns, double nominal_ns) noexcept {
  const std::size_t n = arrivals_ns.size();
  if (n < kFewestArrivals || n > kLongestStretch) return std::nullopt;
  Numbers x{};
  for (std::size_t j = 0; j < n; ++j) x[j] = static_cast<double>(arrivals_ns[j] - arrivals_ns[0]);
  const std::span<const double> x_ns(x.data(), n);
  if (!(x_ns.back() > 0)) return std::nullopt;

  Numbers index{};
  const double period_ns = best_period(x_ns, nominal_ns, index);
  const double earliest = number_readings(x_ns, period_ns, index);
  // The first line starts from the earliest arrivals, so that a stall does not tilt it.
  GridLine line{period_ns, (earliest + index[n - 1]) * period_ns, 0.0};
  line = fit(x_ns, index, line, 2.0);
  for (int again = 0; again < 2; ++again) line = fit(x_ns, index, line, std::max(0.02, kOutlier * line.spread));

  ArrivalGrid grid;
  grid.period_ns = line.period_ns;
  grid.last_ns = line.last_ns;
  grid.spread = line.spread;
  grid.lost = (index[n - 1] - static_cast<double>(n - 1)) / static_cast<double>(n);
  for (std::size_t j = 0; j < n; ++j) {
    const double deviation = (x_ns[j] - line.last_ns) / line.period_ns - (index[j] - index[n - 1]);
    grid.shape.add(deviation);
  }
  grid.shape.learn();
  // periods. A short stretch locks only if the jitter is small; a long one may jitter by more than a period.
  const double most_spread = n < kLongestStretch ? 0.13 : 0.7;
  const bool sound = grid.period_ns > 0 && std::isfinite(grid.last_ns) && grid.spread < most_spread;
  if (!sound || grid.lost > kMostGaps) return std::nullopt;
  return grid;
}

}  // namespace dwell
