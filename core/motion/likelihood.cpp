#include "core/motion/likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/motion/covariance_filter.hpp"
#include "core/motion/gain_schedule.hpp"
#include "core/motion/input_effect.hpp"
#include "core/motion/interval_steps.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The means: state, and its derivatives by θ, the initial state and the biases, side by side.
class Means {
 public:
  Means(const MotionModel& model, const LinearModel& linear, const MotionUnknowns& unknowns, bool derivatives)
      : linear_(linear), theta_(unknowns.theta), bias_(unknowns.bias), p_(derivatives ? unknowns.theta.size() : 0) {
    const Index m = model.states();
    X_ = MatrixXd::Zero(m, derivatives ? 1 + p_ + m + bias_.size() : 1);
    X_.col(0) = unknowns.initial;
    if (derivatives) X_.middleCols(1 + p_, m).setIdentity();
  }

  // Over dt_ns, up to the given reading.
  void propagate(const Step& step, const std::vector<int>& derivative_of, InputEffect& inputs, std::int64_t dt_ns,
                 std::size_t reading) {
    before_ = X_.col(0);
    next_.noalias() = step.F().lazyProduct(X_);
    X_.swap(next_);
    for (Index a = 0; a < p_; ++a)
      if (const int d = derivative_of[static_cast<std::size_t>(a)]; d >= 0)
        X_.col(1 + a).noalias() += step.dF(d).lazyProduct(before_);
    if (inputs.count() == 0) return;
    const auto& effect = inputs.over(dt_ns);
    for (Index i = 0; i < inputs.count(); ++i) {
      const Index a = linear_.inputs[static_cast<std::size_t>(i)];
      X_.col(0) += theta_(a) * inputs.mean(i, reading) * effect.col(i);
      if (p_ > 0) X_.col(1 + a) += inputs.mean(i, reading) * effect.col(i);
    }
  }

  // Innovation of a reading and its derivatives.
  double innovation(const MotionReading& reading, const InputEffect& inputs, std::size_t index) {
    const Index c = reading.channel;
    row_.noalias() = linear_.C.row(c).lazyProduct(X_);
    for (Index i = 0; i < inputs.count(); ++i) {
      const Index a = linear_.inputs[static_cast<std::size_t>(i)];
      row_(0) += theta_(a) * linear_.D(c, i) * inputs.now(i, index);
      if (p_ > 0) row_(1 + a) += linear_.D(c, i) * inputs.now(i, index);
    }
    const double e = reading.value - row_(0) - bias_(c);
    row_ = -row_;
    for (Index a = 0; a < p_; ++a)
      if (const MatrixXd& dC = linear_.dC[static_cast<std::size_t>(a)]; dC.size() > 0)
        row_(1 + a) -= dC.row(c).transpose().dot(X_.col(0));
    if (row_.size() > 1) row_(row_.size() - bias_.size() + c) -= 1.0;
    row_(0) = e;
    return e;
  }
  [[nodiscard]] auto derivatives() const { return row_.tail(row_.size() - 1); }
  void take(const KalmanGain& gain) {
    X_.noalias() += gain.K * row_;
    if (p_ > 0) X_.middleCols(1, p_) += row_(0) * gain.dK;
  }
  [[nodiscard]] auto state() const { return X_.col(0); }

 private:
  const LinearModel& linear_;
  VectorXd theta_, bias_, before_;
  Index p_;
  MatrixXd X_, next_;
  Eigen::RowVectorXd row_;
};

// Score and information, readings taken together in batches: one product instead of many of rank one.
class Sums {
 public:
  Sums(Index size, Index p) : p_(p), by_e_(size, kBatch), by_S_(p, kBatch) {
    score_ = block_ = VectorXd::Zero(size);
    information_ = meat_ = MatrixXd::Zero(size, size);
  }

  void add(const KalmanGain& gain, double e, const Eigen::RowVectorXd& de) {
    const double weight = 1 / std::sqrt(gain.S), part = e * e / gain.S;
    by_e_.col(used_) = de.transpose() * weight;
    by_S_.col(used_) = gain.dS / (gain.S * std::sqrt(2.0));
    block_ += de.transpose() * (e / gain.S);
    block_.head(p_) += gain.dS * (0.5 * (1 - part) / gain.S);
    if (++used_ == kBatch) flush();
  }
  void end_block() {
    meat_.selfadjointView<Eigen::Lower>().rankUpdate(block_);
    score_ += block_;
    block_.setZero();
    ++blocks_;
  }
  void finish(Pass& out) {
    flush();
    end_block();
    out.score = score_;
    out.information = information_.selfadjointView<Eigen::Lower>();
    out.meat = meat_.selfadjointView<Eigen::Lower>();
    out.blocks = blocks_;
  }

 private:
  static constexpr Index kBatch = 64;
  void flush() {
    if (used_ == 0) return;  // Eigen divides by the number of columns
    information_.selfadjointView<Eigen::Lower>().rankUpdate(by_e_.leftCols(used_));
    auto corner = information_.topLeftCorner(p_, p_);
    corner.selfadjointView<Eigen::Lower>().rankUpdate(by_S_.leftCols(used_));
    used_ = 0;
  }
  Index p_, used_ = 0;
  int blocks_ = 0;
  MatrixXd by_e_, by_S_, information_, meat_;
  VectorXd score_, block_;
};

// How much each element deforms, about its mean.
class Deformations {
 public:
  explicit Deformations(const MotionModel& model) {
    const int elements = model.rig().element_count();
    rows_.resize(elements, model.states());
    for (int k = 1; k <= elements; ++k) rows_.row(k - 1) = model.deformation_row(k);
    sum_ = squares_ = variance_ = VectorXd::Zero(elements);
  }
  void add(const Eigen::Ref<const VectorXd>& x, const MatrixXd& P) {
    const VectorXd d = rows_ * x;
    sum_ += d;
    squares_ += d.cwiseAbs2();
    variance_ += (rows_ * P * rows_.transpose()).diagonal();
    ++count_;
  }
  void finish(Pass& out) const {
    const VectorXd mean = sum_ / count_;
    out.deformation = (2.0 * (squares_ / count_ - mean.cwiseAbs2())).cwiseMax(0.0).cwiseSqrt();
    out.deformation_u = (2.0 * variance_ / count_).cwiseMax(0.0).cwiseSqrt();
  }

 private:
  MatrixXd rows_;
  VectorXd sum_, squares_, variance_;
  double count_ = 0.0;
};

}  // namespace

Pass evaluate(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns,
              const PassOptions& options) {
  const LinearModel linear = model.at(unknowns.theta, options.derivatives);
  IntervalSteps steps(linear);
  CovarianceFilter filter(model, linear, unknowns.theta, options.derivatives);
  GainSchedule schedule(filter, steps);
  Means means(model, linear, unknowns, options.derivatives);
  InputEffect inputs(linear, data);
  const auto channels = static_cast<std::size_t>(unknowns.bias.size());
  const Index p = options.derivatives ? unknowns.theta.size() : 0;
  Sums sums(options.derivatives ? p + model.states() + unknowns.bias.size() : 0, p);
  Deformations deformations(model);

  Pass out;
  out.chi2.assign(channels, 0.0);
  out.count.assign(channels, 0.0);
  out.unforeseen.assign(channels, 0.0);
  if (options.keep_innovations) out.innovations.resize(channels);
  std::int64_t now_ns = data.readings.empty() ? 0 : data.readings.front().t_ns;
  const auto block_ns = static_cast<std::int64_t>(options.block_s * 1e9);
  std::int64_t block_end_ns = now_ns + block_ns;
  std::size_t stretch = 0;
  VectorXd before;
  for (std::size_t index = 0; index < data.readings.size(); ++index) {
    const MotionReading& reading = data.readings[index];
    while (stretch + 1 < data.stretches.size() && reading.t_ns >= data.stretches[stretch + 1].from_ns) ++stretch;
    const int intensity = data.stretches.empty() ? 0 : data.stretches[stretch].intensity;
    const GainSchedule::Due due =
        schedule.next(std::max<std::int64_t>(0, reading.t_ns - now_ns), reading.channel, intensity);
    now_ns += due.dt_ns;
    if (options.show) before = means.state();
    if (due.step != nullptr) {
      means.propagate(*due.step, steps.derivative_of(), inputs, due.dt_ns, index);
      if (options.keep_innovations) deformations.add(means.state(), filter.P());
    }
    if (options.show) options.show(before, means.state());
    const double e = means.innovation(reading, inputs, index), S = due.gain->S, part = e * e / S;
    if (!(S > 0.0) || !std::isfinite(part)) {
      out.V = std::numeric_limits<double>::quiet_NaN();
      return out;
    }
    const auto c = static_cast<std::size_t>(reading.channel);
    out.V += 0.5 * (std::log(S) + part);
    out.chi2[c] += part;
    out.count[c] += 1.0;
    out.unforeseen[c] += 1.0 - due.gain->noise / S;
    if (options.keep_innovations) out.innovations[c].push_back({reading.t_ns, e / std::sqrt(S)});
    if (options.derivatives) {
      if (block_ns > 0 && reading.t_ns >= block_end_ns) {
        sums.end_block();
        block_end_ns = reading.t_ns + block_ns;
      }
      sums.add(*due.gain, e, means.derivatives());
    }
    means.take(*due.gain);
  }
  for (std::size_t c = 0; c < channels; ++c)
    if (out.count[c] > 0) {
      out.chi2[c] /= out.count[c];
      out.unforeseen[c] /= out.count[c];
    }
  if (options.derivatives) sums.finish(out);
  if (options.keep_innovations) deformations.finish(out);
  return out;
}

}  // namespace dwell
