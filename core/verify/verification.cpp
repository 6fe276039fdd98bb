#include "core/verify/verification.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/base/wording.hpp"
#include "core/model/forward.hpp"
#include "core/rig/transducer.hpp"
#include "core/verify/comparison.hpp"
#include "core/verify/verdict.hpp"
#include "core/verify/verification_consistency.hpp"
#include "core/verify/verification_residuals.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Draws of noise: u of the prediction is then known to 9 %, and so is the spread of a test's statistic.
constexpr Index kDraws = 64;
constexpr std::uint64_t kSeed = 20161;
// The prediction is made again with every second reading of the table. The error of interpolating all readings is this
// part of the change: 1/16 for a smooth motion, up to a third for a drive that begins with a jump of velocity.
constexpr double kInterpolation = 1.0 / 3;

// A source's column is a difference quotient over this part of its standard deviation: over a whole one the prediction
// may not be linear; over much less, rounding shows.
constexpr double kStep = 0.1;
// Where the test of consistency gives a probability below this, it is made again, linearized about the best amplitudes
// of the sources: the prediction of a lightly damped chain is not linear in a frequency that is far off.
constexpr double kMakeSure = 0.1;
constexpr int kAgain = 2;

// The chain of a dwell; empty masses and elements: it gives none, `why` says it.
Chain chain_of(const Rig& rig, const Dwell& dwell, std::string& why) {
  Chain chain{rig.boundary, rig.masses, {}, {}};
  if (!std::isfinite(dwell.settled_s) || dwell.elements.empty())
    why = "no coefficients: " + (dwell.settling_reason.empty() ? "the dwell has not settled" : dwell.settling_reason);
  for (const ElementEstimate& element : dwell.elements) {
    if (!element.identifiable && why.empty())
      why = "element " + std::to_string(element.k) + " is not identifiable: " + element.reason;
    chain.stiffness.push_back(element.stiffness.value);
    chain.damping.push_back(element.damping.value);
  }
  return chain;
}

bool only_coefficients(const CoefficientError& error) {
  return error.mass == 0 && error.readings.empty() && error.clock_u == 0.0;
}

// The sources of the dwell; all that move nothing but coefficients as the principal axes of their covariance.
std::vector<CoefficientError> sources_of(const Dwell& dwell) {
  const auto count = static_cast<Index>(2 * dwell.elements.size());
  MatrixXd covariance = MatrixXd::Zero(count, count);
  std::vector<CoefficientError> out;
  for (const CoefficientError& error : dwell.errors) {
    if (!only_coefficients(error)) {
      out.push_back(error);
      continue;
    }
    const auto v = Eigen::Map<const VectorXd>(error.on_coefficients.data(), count);
    covariance += v * v.transpose();
  }
  // In units of each coefficient's own u, for they differ by orders of magnitude.
  const VectorXd u = covariance.diagonal().cwiseSqrt().unaryExpr([](double a) { return a > 0 ? a : 1.0; });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(u.cwiseInverse().asDiagonal() * covariance *
                                                     u.cwiseInverse().asDiagonal());
  for (Index i = 0; i < count; ++i) {
    const VectorXd v = std::sqrt(std::max(0.0, axes.eigenvalues()(i))) * u.cwiseProduct(axes.eigenvectors().col(i));
    out.push_back({{v.begin(), v.end()}, 0, 0.0, 0.0, {}});
  }
  return out;
}

// The phasor of each channel's reading, divided by the phasor of the table's displacement.
SteadyRatio steady_ratio(const Rig& rig, const Dwell& dwell, int table) {
  SteadyRatio out;
  const double f_hz = dwell.frequency_hz.value;
  out.omega = kTwoPi * f_hz;
  const auto t = static_cast<std::size_t>(table);
  const std::complex<double> Y0 =
      dwell.phasors[t].Y / std::pow(std::complex<double>{0.0, out.omega}, derivative_order(rig.channels[t].measures));
  for (std::size_t c = 0; c < rig.channels.size(); ++c)
    out.ratio.push_back(dwell.phasors[c].Y * response(rig.channels[c], device_delay_s(rig, rig.channels[c]), f_hz) /
                        Y0);
  return out;
}

// The sources that act on readings or the clock, without their effect on coefficients and masses: these are the model's
// own numbers in U_as_is.
std::vector<CoefficientError> as_read(std::vector<CoefficientError> sources) {
  std::erase_if(sources, [](const CoefficientError& source) { return source.readings.empty() && source.clock_u == 0; });
  for (CoefficientError& source : sources) {
    std::fill(source.on_coefficients.begin(), source.on_coefficients.end(), 0.0);
    source.mass = 0;
  }
  return sources;
}

// Columns: what one standard deviation of each source makes of the error. A source whose test cannot be played (a
// coefficient's u so large that the chain would not decay) is left out, and said.
MatrixXd by_source(const VerificationStretch& stretch, const SteadyTable& table, const Assumption& nominal,
                   const VectorXd& error, const std::vector<CoefficientError>& sources, std::string& why) {
  MatrixXd out = MatrixXd::Zero(error.size(), static_cast<Index>(sources.size()));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const Residuals moved = residuals_of(stretch, table, nominal.moved(sources[i], kStep));
    if (moved.fault.empty())
      out.col(static_cast<Index>(i)) = (moved.error() - error) / kStep;
    else
      why = "the uncertainty of the coefficients is too large to predict with them";
  }
  return out;
}

// Likewise, of interpolating the table's readings.
MatrixXd by_interpolation(const VerificationStretch& stretch, const SteadyTable& table, const Assumption& nominal,
                          const VectorXd& error) {
  MatrixXd out = MatrixXd::Zero(error.size(), 2);
  Index column = 0;
  for (const Knots half : {Knots::even, Knots::odd}) {
    const Residuals moved = residuals_of(stretch, table, nominal, half);
    if (moved.fault.empty()) out.col(column) = kInterpolation * (moved.error() - error);
    ++column;
  }
  return out;
}

MatrixXd beside(const MatrixXd& left, const MatrixXd& right) {
  MatrixXd out(left.rows(), left.cols() + right.cols());
  out << left, right;
  return out;
}

std::vector<Index> ends_of(const VerificationStretch& stretch) {
  std::vector<Index> ends;
  Index end = 0;
  for (const int c : stretch.compared)
    ends.push_back(end +=
                   static_cast<Index>(stretch.readings[static_cast<std::size_t>(c)].t_ns.size() - stretch.unscored(c)));
  return ends;
}

double mean_square(const MatrixXd& columns) {
  return columns.squaredNorm() / static_cast<double>(std::max<Index>(1, columns.size()));
}

// Upper limit (k = 2) of the error that noise may hide in √(mean(e²) - mean(n²)), n being noise. Three things scatter:
// the mean square of noise, as its draws do; its product with the error; and the noise itself, known from `freedom`
// readings.
double unseen(const VectorXd& error, const MatrixXd& noise, double freedom) {
  const double samples = static_cast<double>(std::max<Index>(1, error.size()));
  const VectorXd squares = noise.colwise().squaredNorm().transpose() / samples;
  const double variance =
      (squares.array() - squares.mean()).square().mean() +
      (2 / samples * (noise.transpose() * error)).squaredNorm() / static_cast<double>(noise.cols()) +
      2 / std::max(1.0, freedom) * squares.mean() * squares.mean();
  const double left = std::max(0.0, error.squaredNorm() / samples - squares.mean());
  return std::sqrt(left + 2 * std::sqrt(variance)) - std::sqrt(left);
}

// What one standard deviation of each source makes of the error, a column each.
struct Sources {
  MatrixXd all;      // coefficients, masses and readings move together
  MatrixXd as_read;  // readings alone: the model's coefficients as they are
};

// Figures of channel number i of the stretch, its rows [begin, begin + count). freedom: readings behind its sigma.
ChannelComparison compared(const VerificationStretch& stretch, std::size_t i, Index begin, Index count, double freedom,
                           const Residuals& seen, const Sources& sources) {
  ChannelComparison out;
  out.channel = stretch.compared[i];
  compare(seen.predicted.segment(begin, count), seen.measured.segment(begin, count), out);
  const double sigma = stretch.sigma[static_cast<std::size_t>(out.channel)], samples = static_cast<double>(count);
  const double of_sources = sources.all.middleRows(begin, count).squaredNorm() / samples;
  const double of_prediction = of_sources + mean_square(seen.noise_predicted.middleRows(begin, count));
  const MatrixXd noise = seen.noise_error.middleRows(begin, count);
  const double of_error = of_sources + mean_square(noise);
  const double of_readings = sources.as_read.middleRows(begin, count).squaredNorm() / samples;
  out.noise = std::sqrt(mean_square(noise)) / out.rms;
  out.U = 2 * std::sqrt(of_prediction + sigma * sigma / samples) / out.rms;
  out.U_as_is = (unseen(seen.error().segment(begin, count), noise, freedom) + 2 * std::sqrt(of_readings)) / out.rms;
  out.e_n = out.error * out.rms / (2 * std::sqrt(of_error));
  const double beyond = seen.beyond_steady.segment(begin, count).squaredNorm() / samples -
                        mean_square(seen.noise_beyond_steady.middleRows(begin, count));
  out.beyond_steady = std::sqrt(std::max(0.0, beyond)) / out.rms;
  return out;
}

// Noise and sources drawn, a column each.
MatrixXd drawn(const MatrixXd& noise, const MatrixXd& sources) {
  std::mt19937_64 rng(kSeed + 1);
  std::normal_distribution<double> normal;
  const MatrixXd z = MatrixXd::NullaryExpr(sources.cols(), noise.cols(), [&] { return normal(rng); });
  return noise + sources * z;
}

double freedom_of(const VerificationStretch& stretch, const Dwell& dwell) {
  double freedom = 1e300;
  for (const int c : stretch.compared) freedom = std::min(freedom, dwell.phasors[static_cast<std::size_t>(c)].samples);
  return freedom;
}

// The parts of the test of consistency that stay the same when it is linearized anew.
struct ConsistencyTest {
  const VerificationStretch& stretch;
  const SteadyTable& table;
  const Assumption& nominal;
  const std::vector<CoefficientError>& errors;
  const MatrixXd& noise;  // of the error, a column a draw
  double freedom;

  [[nodiscard]] VectorXd weights() const {
    VectorXd weight(noise.rows());
    Index begin = 0;
    for (const Index end : ends_of(stretch)) {
      weight.segment(begin, end - begin).setConstant(1 / std::sqrt(mean_square(noise.middleRows(begin, end - begin))));
      begin = end;
    }
    return weight;
  }

  // The sources, weighted, and an offset of each channel by one standard deviation of a reading: the subtracted mean of
  // the settled data has an error of its own.
  [[nodiscard]] MatrixXd weighted(const VectorXd& weight, const MatrixXd& sources) const {
    MatrixXd out = MatrixXd::Zero(sources.rows(), sources.cols() + static_cast<Index>(stretch.compared.size()));
    out.leftCols(sources.cols()) = weight.asDiagonal() * sources;
    Index begin = 0, column = sources.cols();
    for (const Index end : ends_of(stretch)) {
      out.col(column++).segment(begin, end - begin).setOnes();
      begin = end;
    }
    return out;
  }

  [[nodiscard]] Consistency test(VectorXd error, MatrixXd sources) const {
    const VectorXd weight = weights();
    const auto count = static_cast<Index>(errors.size());
    for (int again = 0;; ++again) {
      const SourceFit fit(weighted(weight, sources));
      const VectorXd seen_error = weight.cwiseProduct(error);
      Consistency tests =
          consistency_of(fit, seen_error, ends_of(stretch), drawn(weight.asDiagonal() * noise, fit.sources()), freedom);
      if (again == kAgain || tests.p() > kMakeSure) return tests;
      // Extrapolates linearly from the best amplitudes back to zero.
      const VectorXd amplitudes = -fit.amplitudes(seen_error).head(count);
      Assumption there = nominal;
      for (Index i = 0; i < count; ++i) there = there.moved(errors[static_cast<std::size_t>(i)], amplitudes(i));
      const Residuals seen = residuals_of(stretch, table, there);
      std::string why;
      if (!seen.fault.empty()) return tests;
      const VectorXd there_error = seen.error();
      sources = beside(by_source(stretch, table, there, there_error, errors, why),
                       by_interpolation(stretch, table, there, there_error));
      if (!why.empty()) return tests;
      error = there_error - sources.leftCols(count) * amplitudes;
    }
  }
};

void tell_consistency(const Consistency& tests, Verification& out) {
  out.chi2 = tests.chi2;
  out.p = tests.p();
  out.consistent = out.p >= kLeastP;
  if (*out.consistent) return;
  out.reasons.push_back("not consistent: " +
                        std::string(tests.p_chi2 < tests.p_white
                                        ? "the squares left are " + brief(tests.chi2, 3) +
                                              " times what noise and stated uncertainties leave"
                                        : "the residuals are correlated in time, as noise is not"));
}

}  // namespace

Verification verify_transient(const Rig& rig, const Dwell& dwell, const std::vector<ChannelReadings>& before,
                              double accuracy) {
  Verification out;
  out.accuracy = accuracy;
  const auto unverified = [&out](const std::string& why) {
    out.verdict = Verdict::not_verified;
    out.reasons.insert(out.reasons.begin(), why);
    return out;
  };
  std::string why;
  const Chain chain = chain_of(rig, dwell, why);
  if (!why.empty()) return unverified(why);
  if (!(slowest_decay_rate(chain) > 0))
    return unverified("the chain identified does not decay: it is no passive chain");
  VerificationStretch stretch = transient_before(rig, dwell, chain, before);
  if (!stretch.fault.empty()) return unverified(stretch.fault);
  const Assumption nominal(rig, chain);
  stretch.compare_only([model = VirtualTestModel(rig, chain, stretch.table)](int c) { return model.predicts(c); });
  if (stretch.compared.empty()) return unverified("no channel can be predicted from the table's transducer");
  const auto t = static_cast<std::size_t>(stretch.table);
  const SteadyTable table(stretch.readings[t], stretch.sigma[t], stretch.omega, rig.excitation.harmonics);
  const NoiseDraws draws(stretch, kDraws, kSeed);
  const SteadyRatio ratio = steady_ratio(rig, dwell, stretch.table);
  const Residuals seen = residuals_of(stretch, table, nominal, Knots::all, &draws, &ratio);
  if (!seen.fault.empty()) return unverified(seen.fault);
  const std::vector<CoefficientError> errors = sources_of(dwell);
  const VectorXd error = seen.error();
  const MatrixXd interpolation = by_interpolation(stretch, table, nominal, error);
  const Sources sources{beside(by_source(stretch, table, nominal, error, errors, why), interpolation),
                        beside(by_source(stretch, table, nominal, error, as_read(errors), why), interpolation)};

  std::vector<std::string> names;
  for (const Channel& channel : rig.channels) names.push_back(channel.name);
  Index begin = 0;
  const std::vector<Index> ends = ends_of(stretch);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const double freedom = dwell.phasors[static_cast<std::size_t>(stretch.compared[i])].samples;
    out.channels.push_back(compared(stretch, i, begin, ends[i] - begin, freedom, seen, sources));
    begin = ends[i];
  }
  out.evidence.push_back("transient from " + brief(to_s(stretch.score_from_ns), 4) + " s to " +
                         brief(to_s(stretch.until_ns), 4) + " s");
  // Consistency is not tested where U is above 100 % of the rms in any channel.
  const bool determined = std::all_of(out.channels.begin(), out.channels.end(),
                                      [](const ChannelComparison& channel) { return channel.U < 1.0; });
  const ConsistencyTest consistency{stretch, table, nominal, errors, seen.noise_error, freedom_of(stretch, dwell)};
  if (determined) tell_consistency(consistency.test(error, sources.all), out);
  for (ChannelComparison& channel : out.channels) judge(channel, accuracy, out.consistent.value_or(false));
  judge(out, names);
  if (!why.empty()) return unverified(why);  // U lacks a source
  if (out.verdict == Verdict::adequate && !dwell.doubts.empty())
    return unverified("coefficients are doubted: " + dwell.doubts.front().what);
  return out;
}

}  // namespace dwell
