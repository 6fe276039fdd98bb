#include "core/verify/verification_consistency.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kLags = 10;

double whiteness(const VectorXd& left, const std::vector<Index>& ends) {
  double sum = 0.0;
  Index begin = 0;
  for (const Index end : ends) {
    const auto series = left.segment(begin, end - begin);
    const double power = series.squaredNorm();
    for (Index lag = 1; lag <= kLags && lag < series.size() && power > 0; ++lag) {
      const double rho = series.head(series.size() - lag).dot(series.tail(series.size() - lag)) / power;
      sum += static_cast<double>(series.size()) * rho * rho;
    }
    begin = end;
  }
  return sum;
}

// Probability that a value as large comes by chance, of a statistic whose logarithm is normal with the mean and the
// standard deviation of the draws', and `more` relative standard deviation beside.
double by_chance(double value, const VectorXd& draws, double more) {
  const VectorXd logs = draws.array().log();
  const double mean = logs.mean();
  const double variance =
      (logs.array() - mean).square().sum() / static_cast<double>(std::max<Index>(1, logs.size() - 1));
  const double sigma = std::sqrt(variance * (1 + 1.0 / static_cast<double>(logs.size())) + more * more);
  return 0.5 * std::erfc((std::log(value) - mean) / sigma / std::numbers::sqrt2);
}

}  // namespace

double Consistency::p() const { return std::min(1.0, 2 * std::min(p_chi2, p_white)); }

SourceFit::SourceFit(MatrixXd sources) : sources_(std::move(sources)) {
  const Index count = sources_.cols();
  const MatrixXd normal = sources_.transpose() * sources_ + MatrixXd::Identity(count, count);
  inverse_ = normal.ldlt().solve(MatrixXd::Identity(count, count));
}

VectorXd SourceFit::amplitudes(const VectorXd& error) const { return inverse_ * (sources_.transpose() * error); }

VectorXd SourceFit::left(const VectorXd& error) const { return error - sources_ * amplitudes(error); }

double SourceFit::chi2(const VectorXd& error) const {
  const VectorXd z = amplitudes(error);
  return (error - sources_ * z).squaredNorm() + z.squaredNorm();
}

Consistency consistency_of(const SourceFit& fit, const VectorXd& error, const std::vector<Index>& ends,
                           const MatrixXd& draws, double freedom) {
  VectorXd chi2(draws.cols()), white(draws.cols());
  for (Index k = 0; k < draws.cols(); ++k) {
    chi2(k) = fit.chi2(draws.col(k));
    white(k) = whiteness(fit.left(draws.col(k)), ends);
  }
  Consistency out;
  out.left = fit.left(error);
  const double seen = fit.chi2(error);
  out.chi2 = seen / chi2.mean();
  out.p_chi2 = by_chance(seen, chi2, std::sqrt(2 / std::max(1.0, freedom)));
  out.p_white = by_chance(whiteness(out.left, ends), white, 0.0);
  return out;
}

}  // namespace dwell
