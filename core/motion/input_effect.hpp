// What the inputs of a model do to its state from reading to reading.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/motion/interval_steps.hpp"
#include "core/motion/likelihood.hpp"

namespace dwell {

// Over an interval an input is held at its mean.
//
//   x(t) = exp(A t) x(0) + ∫_0^t exp(A u) du B a ū,   the integral being a block of exp([A B; 0 0] t)
class InputEffect {
 public:
  InputEffect(const LinearModel& linear, const MotionData& data)
      : data_(data.inputs), m_(linear.A.rows()), steps_(with_inputs(linear)) {}

  // m × inputs; valid until the next call.
  [[nodiscard]] auto over(std::int64_t dt_ns) { return steps_.over(dt_ns).F().topRightCorner(m_, count()); }
  [[nodiscard]] Eigen::Index count() const { return static_cast<Eigen::Index>(data_.size()); }
  [[nodiscard]] double mean(Eigen::Index input, std::size_t reading) const {
    return data_[static_cast<std::size_t>(input)].mean[reading];
  }
  [[nodiscard]] double now(Eigen::Index input, std::size_t reading) const {
    return data_[static_cast<std::size_t>(input)].now[reading];
  }

 private:
  static LinearModel with_inputs(const LinearModel& linear) {
    const Eigen::Index m = linear.A.rows(), inputs = linear.B.cols();
    LinearModel out;
    out.A = Eigen::MatrixXd::Zero(m + inputs, m + inputs);
    out.A.topLeftCorner(m, m) = linear.A;
    out.A.topRightCorner(m, inputs) = linear.B;
    out.noise_state = linear.noise_state;
    return out;
  }
  const std::vector<MotionInput>& data_;
  Eigen::Index m_;
  IntervalSteps steps_;
};

}  // namespace dwell
