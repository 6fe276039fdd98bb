#include "core/motion/given_table.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/motion/covariance_filter.hpp"
#include "core/motion/input_effect.hpp"
#include "core/motion/interval_steps.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The states that the chain has no part in: the table's, and those of the filters of its transducers.
std::vector<Index> states_of_table(const MotionModel& model, const LinearModel& linear) {
  const Index m = model.states();
  std::vector<bool> of_chain(static_cast<std::size_t>(m), false);
  std::fill_n(of_chain.begin() + model.table_states(), 2 * model.rig().mass_count(), true);
  for (bool more = true; more;) {
    more = false;
    for (Index i = 0; i < m; ++i)
      for (Index j = 0; j < m; ++j)
        if (!of_chain[static_cast<std::size_t>(i)] && of_chain[static_cast<std::size_t>(j)] && linear.A(i, j) != 0)
          of_chain[static_cast<std::size_t>(i)] = more = true;
  }
  std::vector<Index> out;
  for (Index i = 0; i < m; ++i)
    if (!of_chain[static_cast<std::size_t>(i)]) out.push_back(i);
  return out;
}

class GivenTable {
 public:
  GivenTable(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns)
      : model_(model),
        data_(data),
        unknowns_(unknowns),
        linear_(model.at(unknowns.theta, false)),
        table_(states_of_table(model, linear_)),
        steps_(linear_),
        inputs_(linear_, data),
        variance_(model.rig().channels.size(), 0.0) {
    for (std::size_t a = 0; a < model.parameters().size(); ++a) {
      const Parameter& p = model.parameters()[a];
      const double value = unknowns.theta(static_cast<Index>(a));
      if (p.what == Unknown::noise) variance_[static_cast<std::size_t>(p.index)] = std::exp(2 * value);
      if (p.what == Unknown::intensity) {
        intensity_.resize(std::max(intensity_.size(), static_cast<std::size_t>(p.index) + 1));
        intensity_[static_cast<std::size_t>(p.index)] = std::exp(value);
      }
    }
    std::size_t stretch = 0;
    for (const MotionReading& reading : data.readings) {
      while (stretch + 1 < data.stretches.size() && reading.t_ns >= data.stretches[stretch + 1].from_ns) ++stretch;
      stretch_of_.push_back(data.stretches.empty() ? 0 : data.stretches[stretch].intensity);
    }
  }

  std::vector<std::vector<MotionInnovation>> run() {
    look_back();
    std::vector<std::vector<MotionInnovation>> out(variance_.size());
    CovarianceFilter filter(model_, linear_, unknowns_.theta, false);
    VectorXd x = unknowns_.initial;
    KalmanGain gain;
    for (std::size_t i = 0; i < data_.readings.size(); ++i) {
      const MotionReading& reading = data_.readings[i];
      if (const std::int64_t dt_ns = interval_ns(i); dt_ns > 0) {
        const Step& step = steps_.over(dt_ns);
        x = step.F() * x;
        const auto& effect = inputs_.over(dt_ns);
        for (Index k = 0; k < inputs_.count(); ++k) x += size_of(k) * inputs_.mean(k, i) * effect.col(k);
        filter.propagate(step, {}, stretch_of_[i]);
      }
      const double y = reading.value - unknowns_.bias(reading.channel);
      double e = y - linear_.C.row(reading.channel).dot(x);
      for (Index k = 0; k < inputs_.count(); ++k) e -= size_of(k) * linear_.D(reading.channel, k) * inputs_.now(k, i);
      if (!shows_table(i))
        out[static_cast<std::size_t>(reading.channel)].push_back({reading.t_ns, normalized(i, e, x, filter.P())});
      filter.take(reading.channel, gain);
      x += gain.K * e;
    }
    return out;
  }

 private:
  // Of an input, as estimated.
  [[nodiscard]] double size_of(Index input) const {
    return unknowns_.theta(linear_.inputs[static_cast<std::size_t>(input)]);
  }
  [[nodiscard]] bool shows_table(std::size_t i) const {
    return shows_drive(model_.rig().channels[static_cast<std::size_t>(data_.readings[i].channel)]);
  }
  // To reading i from the one before.
  [[nodiscard]] std::int64_t interval_ns(std::size_t i) const {
    return i == 0 ? 0 : std::max<std::int64_t>(0, data_.readings[i].t_ns - data_.readings[i - 1].t_ns);
  }

  // What the readings of the table behind each other reading say: Λ and λ side by side, at that reading's instant.
  void look_back() {
    const auto size = static_cast<Index>(table_.size());
    MatrixXd L = MatrixXd::Zero(size, size + 1);  // Λ | λ
    later_.resize(size, (size + 1) * static_cast<Index>(data_.readings.size()));
    for (std::size_t i = data_.readings.size(); i-- > 0;) {
      later_.middleCols(static_cast<Index>(i) * (size + 1), size + 1) = L;
      const MotionReading& reading = data_.readings[i];
      if (shows_table(i)) {
        const VectorXd c = linear_.C.row(reading.channel)(table_).transpose();
        const double variance = variance_[static_cast<std::size_t>(reading.channel)];
        L.leftCols(size) += c * c.transpose() / variance;
        L.col(size) += c * (reading.value - unknowns_.bias(reading.channel)) / variance;
      }
      const std::int64_t dt_ns = interval_ns(i);
      if (dt_ns == 0) continue;
      const Step& step = steps_.over(dt_ns);
      const MatrixXd F = step.F()(table_, table_);
      const MatrixXd Q = intensity_[static_cast<std::size_t>(stretch_of_[i])] * step.Q()(table_, table_);
      const MatrixXd JL = (MatrixXd::Identity(size, size) + L.leftCols(size) * Q).partialPivLu().solve(L);
      const MatrixXd half = F.transpose() * JL.leftCols(size) * F;
      L.leftCols(size) = 0.5 * (half + half.transpose());
      L.col(size) = F.transpose() * JL.col(size);
    }
  }

  // e/√S of reading i with what comes later of the table taken in; e: without.
  [[nodiscard]] double normalized(std::size_t i, double e, const VectorXd& x, const MatrixXd& P) const {
    const auto size = static_cast<Index>(table_.size());
    const auto later = later_.middleCols(static_cast<Index>(i) * (size + 1), size + 1);
    const auto C = linear_.C.row(data_.readings[i].channel);
    const VectorXd toward = P * C.transpose();
    const VectorXd toward_table = toward(table_);
    MatrixXd right(size, 2);
    right << later.col(size) - later.leftCols(size) * x(table_), later.leftCols(size) * toward_table;
    const MatrixXd solved =
        (MatrixXd::Identity(size, size) + later.leftCols(size) * P(table_, table_)).partialPivLu().solve(right);
    const double variance = variance_[static_cast<std::size_t>(data_.readings[i].channel)];
    const double S = C.dot(toward) - toward_table.dot(solved.col(1));
    return (e - toward_table.dot(solved.col(0))) / std::sqrt(std::max(S, 0.0) + variance);
  }

  const MotionModel& model_;
  const MotionData& data_;
  const MotionUnknowns& unknowns_;
  LinearModel linear_;
  std::vector<Index> table_;
  IntervalSteps steps_;
  InputEffect inputs_;
  std::vector<double> variance_, intensity_;
  std::vector<int> stretch_of_;  // per reading
  MatrixXd later_;               // per reading, Λ | λ
};

}  // namespace

std::vector<std::vector<MotionInnovation>> innovations_given_table(const MotionModel& model, const MotionData& data,
                                                                   const MotionUnknowns& unknowns) {
  return GivenTable(model, data, unknowns).run();
}

}  // namespace dwell
