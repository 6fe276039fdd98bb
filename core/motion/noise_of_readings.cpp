#include "core/motion/noise_of_readings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

namespace dwell {
namespace {

// Neighbours on each side. More than six keep less than a fifteenth of the band, and of few readings hardly one
// residual that is independent.
constexpr std::size_t kFewestBeside = 2, kMostBeside = 6;
// Of a normal distribution's standard deviation by its median deviation: variance over that of the best estimate.
constexpr double kMedianEfficiency = 0.37;
constexpr double kSigmaOfMedian = 1.4826;

constexpr std::size_t kMostWeights = 2 * kMostBeside + 1;
using Weights = std::array<double, kMostWeights>;

// Of t_0 … t_2m: with which a polynomial through all but the middle one foresees that one; the middle's is -1.
Weights residual_weights(const double* t, std::size_t beside) {
  Weights weights{};
  weights[beside] = -1.0;
  for (std::size_t a = 0; a <= 2 * beside; ++a) {
    if (a == beside) continue;
    double weight = 1.0;
    for (std::size_t b = 0; b <= 2 * beside; ++b)
      if (b != beside && b != a && t[a] != t[b]) weight *= (t[beside] - t[b]) / (t[a] - t[b]);
    weights[a] = weight;
  }
  return weights;
}

double squares_of(const Weights& weights) {
  return std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
}

// u(σ)/σ of `count` residuals.
double relative_u(std::size_t beside, double count) {
  std::array<double, kMostWeights> t{};
  std::iota(t.begin(), t.end(), 0.0);
  const Weights weights = residual_weights(t.data(), beside);
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
    const Weights weights = residual_weights(&t[i], beside);
    const double residual = std::inner_product(&value[i], &value[i] + 2 * beside + 1, weights.begin(), 0.0);
    residuals.push_back(std::abs(residual) / std::sqrt(squares_of(weights)));
  }
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return kSigmaOfMedian * *middle * (1 + relative_u(beside, static_cast<double>(residuals.size())));
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
