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
#include "core/verify/frac.hpp"
#include "core/verify/verdict.hpp"
#include "core/verify/verification_consistency.hpp"
#include "core/verify/verification_evidence.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Seed of the drawn sources.
constexpr std::uint64_t kSeed = 20162;
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
// Periods of another dwell's steady motion that are compared. So many show a wrong amplitude beside noise. A transient
// often has as many, so they do not outweigh it.
constexpr double kSteadyOfOther = 10.0;

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
MatrixXd by_source(const VerificationEvidence& evidence, const Assumption& nominal, const VectorXd& error,
                   const std::vector<CoefficientError>& sources, std::string& why) {
  MatrixXd out = MatrixXd::Zero(error.size(), static_cast<Index>(sources.size()));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const Residuals moved = evidence.residuals(nominal.moved(sources[i], kStep));
    if (moved.fault.empty())
      out.col(static_cast<Index>(i)) = (moved.error() - error) / kStep;
    else
      why = "the uncertainty of the coefficients is too large to predict with them";
  }
  return out;
}

// Likewise, of interpolating the table's readings.
MatrixXd by_interpolation(const VerificationEvidence& evidence, const Assumption& nominal, const VectorXd& error) {
  MatrixXd out = MatrixXd::Zero(error.size(), 2);
  Index column = 0;
  for (const Knots half : {Knots::even, Knots::odd}) {
    const Residuals moved = evidence.residuals(nominal, half);
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

double mean_square(const MatrixXd& columns) {
  return columns.squaredNorm() / static_cast<double>(std::max<Index>(1, columns.size()));
}

// Some rows of a matrix. A matrix without columns has no memory, so no pointer to one of its rows is formed.
MatrixXd rows_of(const MatrixXd& matrix, Index begin, Index count) {
  return matrix.cols() == 0 ? MatrixXd(count, 0) : MatrixXd(matrix.middleRows(begin, count));
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

// Change of the error by one standard deviation of each source; a column per source.
struct Sources {
  MatrixXd all;      // coefficients, masses and readings move together
  MatrixXd as_read;  // readings alone: the model's coefficients as they are
};

// Figures of one channel.
ChannelComparison compared(const VerificationEvidence::Rows& rows, const Residuals& seen, const Sources& sources) {
  const Index begin = rows.begin, count = rows.count;
  ChannelComparison out;
  out.channel = rows.channel;
  compare(seen.predicted.segment(begin, count), seen.measured.segment(begin, count), out);
  const double sigma = rows.sigma, samples = static_cast<double>(count);
  const double of_sources = rows_of(sources.all, begin, count).squaredNorm() / samples;
  const double of_prediction = of_sources + mean_square(rows_of(seen.noise_predicted, begin, count));
  const MatrixXd noise = rows_of(seen.noise_error, begin, count);
  const double of_error = of_sources + mean_square(noise);
  const double of_readings = rows_of(sources.as_read, begin, count).squaredNorm() / samples;
  out.noise = std::sqrt(mean_square(noise)) / out.rms;
  out.U = 2 * std::sqrt(of_prediction + sigma * sigma / samples) / out.rms;
  out.U_as_is =
      (unseen(seen.error().segment(begin, count), noise, rows.freedom) + 2 * std::sqrt(of_readings)) / out.rms;
  out.e_n = out.error * out.rms / (2 * std::sqrt(of_error));
  const double beyond = seen.beyond_steady.segment(begin, count).squaredNorm() / samples -
                        mean_square(rows_of(seen.noise_beyond_steady, begin, count));
  out.beyond_steady = std::sqrt(std::max(0.0, beyond)) / out.rms;
  return out;
}

// Noise and sources drawn, a column each.
MatrixXd drawn(const MatrixXd& noise, const MatrixXd& sources) {
  std::mt19937_64 rng(kSeed);
  std::normal_distribution<double> normal;
  const MatrixXd z = MatrixXd::NullaryExpr(sources.cols(), noise.cols(), [&] { return normal(rng); });
  return noise + sources * z;
}

// The parts of the test of consistency that stay the same when it is linearized anew.
struct ConsistencyTest {
  const VerificationEvidence& evidence;
  const Assumption& nominal;
  const std::vector<CoefficientError>& errors;
  const MatrixXd& noise;  // of the error, a column a draw
  double freedom;

  [[nodiscard]] VectorXd weights() const {
    VectorXd weight(noise.rows());
    Index begin = 0;
    for (const Index end : evidence.ends()) {
      weight.segment(begin, end - begin).setConstant(1 / std::sqrt(mean_square(noise.middleRows(begin, end - begin))));
      begin = end;
    }
    return weight;
  }

  // The sources, weighted, and an offset of each channel in each stretch by one standard deviation of a reading: the
  // subtracted mean of the settled data has an error of its own.
  [[nodiscard]] MatrixXd weighted(const VectorXd& weight, const MatrixXd& sources) const {
    MatrixXd out = MatrixXd::Zero(sources.rows(), sources.cols() + static_cast<Index>(evidence.ends().size()));
    out.leftCols(sources.cols()) = weight.asDiagonal() * sources;
    Index begin = 0, column = sources.cols();
    for (const Index end : evidence.ends()) {
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
          consistency_of(fit, seen_error, evidence.ends(), drawn(weight.asDiagonal() * noise, fit.sources()), freedom);
      if (again == kAgain || tests.p() > kMakeSure) return tests;
      // Extrapolates linearly from the best amplitudes back to zero.
      const VectorXd amplitudes = -fit.amplitudes(seen_error).head(count);
      Assumption there = nominal;
      for (Index i = 0; i < count; ++i) there = there.moved(errors[static_cast<std::size_t>(i)], amplitudes(i));
      const Residuals seen = evidence.residuals(there);
      std::string why;
      if (!seen.fault.empty()) return tests;
      const VectorXd there_error = seen.error();
      sources =
          beside(by_source(evidence, there, there_error, errors, why), by_interpolation(evidence, there, there_error));
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

// Collects the transient before the dwell and the other dwells; lists them in `out`. Returns why there is no evidence.
std::string gather(const Rig& rig, const Dwell& dwell, const Chain& chain, const std::vector<ChannelReadings>& before,
                   const std::vector<OtherDwell>& others, VerificationEvidence& evidence, Verification& out) {
  std::string why;
  const auto add = [&](VerificationStretch stretch, const Dwell& of, const std::string& name) {
    if (stretch.fault.empty()) {
      const VirtualTestModel model(rig, chain, stretch.table);
      stretch.compare_only(
          [&](int c) { return model.predicts(c) && dwell.phasors[static_cast<std::size_t>(c)].valid; });
      if (stretch.compared.empty()) stretch.fault = "no channel can be predicted from the table's transducer";
    }
    if (stretch.fault.empty()) {
      out.evidence.push_back(name + " from " + brief(to_s(stretch.score_from_ns), 4) + " s to " +
                             brief(to_s(stretch.until_ns), 4) + " s");
      evidence.add(std::move(stretch), of, rig);
    } else if (why.empty()) {
      why = stretch.fault;
    }
  };
  add(transient_before(rig, dwell, chain, before), dwell, "transient");
  for (const OtherDwell& other : others) {
    const double f_hz = other.dwell.frequency_hz.value;
    add(motion_of(rig, other.dwell, chain, other.readings,
                  same_frequency(other.dwell, dwell) ? 0.0 : kSteadyOfOther / f_hz),
        other.dwell, "dwell " + std::to_string(other.dwell.index.value_or(0)) + " at " + brief(f_hz, 4) + " Hz");
  }
  return evidence.empty() ? why : "";
}

// The settled dwells, the farthest in frequency first. A dwell whose coefficients are doubted stays in: only its
// readings are used, and a wrong model raises just such doubts.
std::vector<OtherDwell> chosen(const Dwell& dwell, std::vector<OtherDwell> others) {
  std::erase_if(others, [](const OtherDwell& other) { return !std::isfinite(other.dwell.settled_s); });
  const auto far = [&](const OtherDwell& other) {
    return std::abs(std::log(other.dwell.frequency_hz.value / dwell.frequency_hz.value));
  };
  std::stable_sort(others.begin(), others.end(),
                   [&](const OtherDwell& a, const OtherDwell& b) { return far(a) > far(b); });
  return others;
}

void add_frac(const Rig& rig, const Chain& chain, const Dwell& dwell, const std::vector<OtherDwell>& others,
              Verification& out) {
  std::vector<const Dwell*> dwells{&dwell};
  for (const OtherDwell& other : others) dwells.push_back(&other.dwell);
  const std::vector<double> values = frac(rig, chain, dwells);
  for (ChannelComparison& channel : out.channels) channel.frac = values[static_cast<std::size_t>(channel.channel)];
}

// Figures, consistency and verdict. Returns why the uncertainty is not complete; empty: it is.
std::string compare_all(const VerificationEvidence& evidence, const Assumption& nominal, const Dwell& dwell,
                        const Residuals& seen, Verification& out) {
  const std::vector<CoefficientError> errors = sources_of(dwell);
  const VectorXd error = seen.error();
  std::string why;
  const MatrixXd interpolation = by_interpolation(evidence, nominal, error);
  const Sources sources{beside(by_source(evidence, nominal, error, errors, why), interpolation),
                        beside(by_source(evidence, nominal, error, as_read(errors), why), interpolation)};
  double freedom = 1e300;
  for (const VerificationEvidence::Rows& rows : evidence.channels()) {
    out.channels.push_back(compared(rows, seen, sources));
    freedom = std::min(freedom, rows.freedom);
  }
  // Consistency is not tested where U is above 100 % of the rms in any channel.
  const bool determined = std::all_of(out.channels.begin(), out.channels.end(),
                                      [](const ChannelComparison& channel) { return channel.U < 1.0; });
  const ConsistencyTest consistency{evidence, nominal, errors, seen.noise_error, freedom};
  if (determined) tell_consistency(consistency.test(error, sources.all), out);
  return why;
}

}  // namespace

Verification verify_model(const Rig& rig, const Dwell& dwell, const std::vector<ChannelReadings>& before,
                          double accuracy, const std::vector<OtherDwell>& others) {
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
  const std::vector<OtherDwell> settled = chosen(dwell, others);
  VerificationEvidence evidence;
  why = gather(rig, dwell, chain, before,
               {settled.begin(), settled.begin() + static_cast<std::ptrdiff_t>(std::min(settled.size(), kMostOthers))},
               evidence, out);
  if (!why.empty()) return unverified(why);
  const Assumption nominal(rig, chain);
  const SteadyRatio ratio = steady_ratio(rig, dwell, evidence.table());
  const Residuals seen = evidence.residuals(nominal, Knots::all, true, &ratio);
  if (!seen.fault.empty()) return unverified(seen.fault);
  why = compare_all(evidence, nominal, dwell, seen, out);
  add_frac(rig, chain, dwell, settled, out);
  std::vector<std::string> names;
  for (const Channel& channel : rig.channels) names.push_back(channel.name);
  for (ChannelComparison& channel : out.channels) judge(channel, accuracy, out.consistent.value_or(false));
  judge(out, names);
  if (!why.empty()) return unverified(why);  // U lacks a source
  if (out.verdict == Verdict::adequate && !dwell.doubts.empty())
    return unverified("coefficients are doubted: " + dwell.doubts.front().what);
  return out;
}

}  // namespace dwell
