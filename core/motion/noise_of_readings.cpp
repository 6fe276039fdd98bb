#include "core/motion/noise_of_readings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/median.hpp"
#include "core/base/neighbour_weights.hpp"

namespace dwell {
namespace {

// Neighbours on each side. With six, one residual in 4.4 is independent (Σ ρ²), with two, one in 2.6. More were not
// tried: the work grows as the square.
constexpr std::size_t kFewestBeside = 2, kMostBeside = 6;
// For normal residuals, σ from the median deviation has 1/0.37 = 2.7 times the variance of the best estimate of σ.
constexpr double kMedianEfficiency = 0.37;

constexpr std::size_t kMostWeights = 2 * kMostBeside + 1;
using Weights = std::array<double, kMostWeights>;

Weights weights_at(const double* t, std::size_t beside) {
  Weights weights{};
  neighbour_weights(t, beside, weights.data());
  return weights;
}

double squares_of(const Weights& weights) {
  return std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
}

// u(σ)/σ of `count` residuals.
double relative_u(std::size_t beside, double count) {
  std::array<double, kMostWeights> t{};
  std::iota(t.begin(), t.end(), 0.0);
  const Weights weights = weights_at(t.data(), beside);
  double correlated = 0.0;
  for (std::size_t k = 0; k <= 2 * beside; ++k) {
    const double rho =
        std::inner_product(weights.begin() + static_cast<std::ptrdiff_t>(k), weights.end(), weights.begin(), 0.0) /
        squares_of(weights);
    correlated += (k == 0 ? 1.0 : 2.0) * rho * rho;
  }
  return std::sqrt(correlated / (2 * count * kMedianEfficiency));
}

double sigma_at(const std::vector<double>& t, const std::vector<double>& value, std::size_t beside) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i + 2 * beside < t.size(); ++i) {
    const Weights weights = weights_at(&t[i], beside);
    const double residual = std::inner_product(&value[i], &value[i] + 2 * beside + 1, weights.begin(), 0.0);
    residuals.push_back(std::abs(residual) / std::sqrt(squares_of(weights)));
  }
  const double widened = 1 + relative_u(beside, static_cast<double>(residuals.size()));
  return kSigmaOfMedian * median(std::move(residuals)) * widened;
}

}  // namespace

double noise_of_readings(const std::vector<double>& t, const std::vector<double>& value) {
  double least = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t m = kFewestBeside; m <= kMostBeside && t.size() > 4 * m; ++m) {
    const double sigma = sigma_at(t, value, m);
    if (sigma >= least) break;  // the motion no longer shows
    least = sigma;
  }
  return least;
}

}  // namespace dwell
