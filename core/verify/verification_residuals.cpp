#include "core/verify/verification_residuals.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "core/base/instants.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Prior standard deviation of an initial state, in amplitudes of the readings. It is larger than any real state, so it
// adds nothing where the readings determine the state, and keeps the state finite where they do not.
constexpr double kPrior = 10.0;

// A prediction larger than this many measured amplitudes counts as diverged.
constexpr double kDiverged = 1e6;

// The players of the virtual test: the measured table, a constant reading where it is integrated, draws of noise, and
// the initial conditions.
class Players {
 public:
  Players(const VerificationStretch& stretch, const SteadyTable& table, const Assumption& assumption, Knots knots,
          const NoiseDraws* draws)
      : stretch_(stretch),
        table_(table),
        assumption_(assumption),
        test_(assumption.rig, assumption.chain, stretch.table),
        draws_(draws),
        constant_(test_.fault().empty() && test_.model().integrals() > 0 ? 1 : 0) {
    if (test_.fault().empty()) play(knots);
  }
  [[nodiscard]] const std::string& fault() const noexcept { return test_.fault(); }
  [[nodiscard]] bool predicts(int c) const { return test_.model().predicts(c); }
  [[nodiscard]] Index draws() const { return draws_ != nullptr ? draws_->draws : 0; }
  [[nodiscard]] Index unknowns() const { return constant_ + test_.model().states(); }
  // Of channel c, readings as columns: driven (the measured table, then the draws) and by each unknown.
  [[nodiscard]] MatrixXd driven(int c) const { return of(c).middleRows(constant_, 1 + draws()); }
  [[nodiscard]] MatrixXd by_unknown(int c) const {
    MatrixXd out(unknowns(), of(c).cols());
    out.topRows(constant_) = of(c).topRows(constant_);
    out.bottomRows(test_.model().states()) = of(c).bottomRows(test_.model().states());
    return out;
  }
  // The measured values, and the noise of each draw, of the same readings.
  [[nodiscard]] MatrixXd read(int c) const {
    const auto i = static_cast<std::size_t>(c);
    const std::vector<double>& value = stretch_.readings[i].value;
    MatrixXd out(1 + draws(), static_cast<Index>(value.size()));
    out.row(0) =
        assumption_.gain[i] * Eigen::Map<const Eigen::RowVectorXd>(value.data(), static_cast<Index>(value.size()));
    if (draws_ != nullptr) out.bottomRows(draws()) = draws_->of_channel[i];
    return out;
  }
  [[nodiscard]] std::int64_t taken_ns(std::int64_t t_ns) const {
    if (assumption_.fast == 0.0) return t_ns;
    return stretch_.score_from_ns + to_ns(to_s(t_ns - stretch_.score_from_ns) / (1 + assumption_.fast));
  }
  // The table's own motion at the readings of channel c: y_0 and y_0', driven as above.
  [[nodiscard]] std::pair<MatrixXd, MatrixXd> table_motion(int c, const VirtualTestInput& input) const {
    Rig rig = assumption_.rig;
    Channel motion;
    rig.channels = {rig.channels[static_cast<std::size_t>(stretch_.table)], motion, motion};
    rig.channels[2].measures = Quantity::velocity;
    const VirtualTest test(rig, assumption_.chain, 0);
    const Instants& instants = stretch_.readings[static_cast<std::size_t>(c)].t_ns;
    const auto seen =
        test.play(input, MatrixXd::Zero(test.model().states(), input.readings()), {{}, instants, instants});
    return {seen[1].middleRows(constant_, 1 + draws()), seen[2].middleRows(constant_, 1 + draws())};
  }
  [[nodiscard]] const VirtualTestInput& input() const { return *input_; }

 private:
  [[nodiscard]] const MatrixXd& of(int c) const { return played_[static_cast<std::size_t>(c)]; }

  void play(Knots knots) {
    const MatrixXd values = table_.apply(read(stretch_.table));
    const Instants& given = table_.instants();
    const std::size_t step = knots == Knots::all ? 1 : 2;
    Instants t_ns;
    std::vector<Index> columns;
    for (std::size_t i = knots == Knots::odd ? 1 : 0; i < given.size(); i += step) {
      t_ns.push_back(taken_ns(given[i]) - test_.model().delay_ns(stretch_.table));
      columns.push_back(static_cast<Index>(i));
    }
    MatrixXd inputs(constant_ + values.rows(), static_cast<Index>(columns.size()));
    inputs.topRows(constant_).setOnes();
    inputs.bottomRows(values.rows()) = values(Eigen::all, columns);
    input_.emplace(std::move(t_ns), std::move(inputs));
    const Index states = test_.model().states();
    MatrixXd initial = MatrixXd::Zero(states, input_->readings() + states);
    initial.rightCols(states).setIdentity();
    std::vector<Instants> instants(stretch_.readings.size());
    for (const int c : stretch_.compared)
      for (const std::int64_t at_ns : stretch_.readings[static_cast<std::size_t>(c)].t_ns)
        instants[static_cast<std::size_t>(c)].push_back(taken_ns(at_ns));
    played_ = test_.play(*input_, initial, instants);
  }

  const VerificationStretch& stretch_;
  const SteadyTable& table_;
  const Assumption& assumption_;
  VirtualTest test_;
  const NoiseDraws* draws_;
  Index constant_;
  std::optional<VirtualTestInput> input_;
  std::vector<PredictedReadings> played_;
};

// The first predicted reading of channel c: there is no prediction before the input's first knot.
Index first_known(const MatrixXd& driven) {
  Index first = 0;
  while (first < driven.cols() && !std::isfinite(driven(0, first))) ++first;
  return first;
}

// Unknowns × (1 + draws): the initial states that fit the unscored readings best.
MatrixXd initial_conditions(const VerificationStretch& stretch, const Players& players) {
  const Index unknowns = players.unknowns();
  MatrixXd normal = MatrixXd::Zero(unknowns, unknowns), right = MatrixXd::Zero(unknowns, 1 + players.draws());
  double shown = 0.0;
  for (const int c : stretch.compared) {
    if (!players.predicts(c)) continue;
    const MatrixXd driven = players.driven(c);
    const Index first = first_known(driven), count = static_cast<Index>(stretch.unscored(c)) - first;
    if (count <= 0) continue;
    const double sigma = stretch.sigma[static_cast<std::size_t>(c)];
    const MatrixXd by = players.by_unknown(c).middleCols(first, count) / sigma;
    const MatrixXd left = (players.read(c) - driven).middleCols(first, count) / sigma;
    normal += by * by.transpose();
    right += by * left.transpose();
    shown += players.read(c).row(0).segment(first, count).squaredNorm() / (sigma * sigma) + static_cast<double>(count);
  }
  const VectorXd size = normal.diagonal().cwiseSqrt().unaryExpr([](double s) { return s > 0 ? s : 1.0; });
  MatrixXd scaled = size.cwiseInverse().asDiagonal() * normal * size.cwiseInverse().asDiagonal();
  scaled.diagonal().array() += 1 / (kPrior * kPrior * std::max(shown, 1.0));
  return size.cwiseInverse().asDiagonal() * scaled.ldlt().solve(size.cwiseInverse().asDiagonal() * right);
}

}  // namespace

Assumption Assumption::moved(const CoefficientError& error, double part) const {
  Assumption out = *this;
  for (std::size_t e = 0; e < chain.stiffness.size(); ++e) {
    out.chain.stiffness[e] += part * error.on_coefficients[2 * e];
    out.chain.damping[e] += part * error.on_coefficients[2 * e + 1];
  }
  if (error.mass > 0) {
    const auto i = static_cast<std::size_t>(error.mass - 1);
    out.rig.masses[i] += part * error.mass_u;
    out.chain.masses[i] += part * error.mass_u;
  }
  out.fast += part * error.clock_u;
  for (const ReadingError& reading : error.readings) {
    const auto c = static_cast<std::size_t>(reading.channel);
    Channel& channel = out.rig.channels[c];
    out.gain[c] *= 1 + part * reading.relative;
    channel.delay_s += part * reading.late_s;
    channel.lowpass.hz += part * reading.lowpass_hz;
    channel.highpass.hz += part * reading.highpass_hz;
  }
  return out;
}

NoiseDraws::NoiseDraws(const VerificationStretch& stretch, Index count, std::uint64_t seed) : draws(count) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  for (std::size_t c = 0; c < stretch.readings.size(); ++c) {
    const std::vector<double> relative = stretch.timing[c].relative_to_steady(stretch.readings[c]);
    of_channel.push_back(MatrixXd::NullaryExpr(draws, static_cast<Index>(relative.size()), [&](Index, Index i) {
      return stretch.sigma[c] * relative[static_cast<std::size_t>(i)] * normal(rng);
    }));
  }
}

Residuals residuals_of(const VerificationStretch& stretch, const SteadyTable& table, const Assumption& assumption,
                       Knots knots, const NoiseDraws* draws, const SteadyRatio* steady) {
  Residuals out;
  const Players players(stretch, table, assumption, knots, draws);
  out.fault = players.fault();
  if (!out.fault.empty()) return out;
  const MatrixXd unknown = initial_conditions(stretch, players);
  const auto total = static_cast<Index>(stretch.scored());
  MatrixXd predicted(1 + players.draws(), total), read = predicted, beyond = MatrixXd::Zero(1 + players.draws(), total);
  Index at = 0;
  for (const int c : stretch.compared) {
    const MatrixXd whole = players.read(c);
    const auto skip = static_cast<Index>(stretch.unscored(c)), count = whole.cols() - skip;
    const MatrixXd by = players.by_unknown(c).rightCols(count);
    predicted.middleCols(at, count) = players.driven(c).rightCols(count) + unknown.transpose() * by;
    read.middleCols(at, count) = whole.rightCols(count);
    if (steady != nullptr) {
      const std::complex<double> ratio = steady->ratio[static_cast<std::size_t>(c)];
      const auto [y, velocity] = players.table_motion(c, players.input());
      beyond.middleCols(at, count) = predicted.middleCols(at, count) -
                                     (ratio.real() * y + ratio.imag() / steady->omega * velocity).rightCols(count);
    }
    at += count;
  }
  const double size = read.row(0).norm();
  if (!predicted.allFinite() || predicted.row(0).norm() > kDiverged * size) {
    out.fault = "the prediction diverges: these coefficients are not those of a chain that decays";
    return out;
  }
  out.predicted = predicted.row(0).transpose();
  out.measured = read.row(0).transpose();
  out.beyond_steady = beyond.row(0).transpose();
  out.noise_predicted = predicted.bottomRows(players.draws()).transpose();
  out.noise_error = (predicted - read).bottomRows(players.draws()).transpose();
  out.noise_beyond_steady = beyond.bottomRows(players.draws()).transpose();
  return out;
}

}  // namespace dwell
