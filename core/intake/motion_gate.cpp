#include "core/intake/motion_gate.hpp"

#include <algorithm>

namespace dwell {
namespace {

constexpr std::size_t kEven = 3;                     // readings in a row that go on evenly are another motion
constexpr double kStepNoise = 0.29;                  // standard deviation of rounding, steps: 1 / √12
constexpr double kTied = 3.0, kTiedByChance = 1e-8;  // in medians, the least k; see the header
constexpr double kTiedRounding = 2.5;
constexpr double kRefresh = 5.0;  // 1 + Σ|w|: the instants of the points are as uncertain

}  // namespace

MotionGate::Says MotionGate::judge(const Reading& reading, double omega, double step) noexcept {
  given_back_ = 0;
  const MotionPredictor::Prediction predicted = predictor_.predict(reading.t_ns, last_ns_, omega);
  last_ns_ = reading.t_ns;
  const bool tied = recent_.has(reading.value) || (foreign_.cluster() && reading.value == foreign_.value());
  if (recent_.newest() != reading.value) recent_.add(reading.value);
  lateness_.see(reading.half_ns, !errors_.known());
  const bool by_far = lateness_.by_far(reading.half_ns), predictable = predicted.gain > 0 && std::isfinite(step);
  active_ = predictable && errors_.known();
  if (!predictable) {
    if (predictor_.full()) predictor_.restart();  // a pause, or too few readings a period: begin anew
    leave_waiting();
    follow(reading);
    return counts(!by_far);
  }
  const double error = std::abs(reading.value - predicted.value), relative = error / predicted.gain;
  if (!errors_.known()) {
    errors_.learn(relative);
    follow(reading);
    return counts(!by_far);
  }
  const double far = predicted.gain * kFar * errors_.median() + kRounding * step;
  const double limit = tied ? predicted.gain * tied_medians(step) * errors_.median() + kTiedRounding * step : far;
  // The instant's half width only raises a limit. Few readings need it, and it costs a division.
  const auto moves = [&](double half_ns) { return predictor_.slope(predicted, reading.t_ns) * 1e-9 * half_ns; };
  const auto late = [&] { return moves(reading.half_ns + kRefresh * reading.refresh_half_ns); };
  if (error <= limit || error <= limit + late()) {
    leave_waiting();
    errors_.add(relative);
    follow(reading);
    const bool rare = by_far && lateness_.rare();
    return counts(
        !lateness_.held_up(reading.half_ns) ||
        (!rare && moves(reading.half_ns) <= AnswerLateness::kUncertain * std::max(noise(), kStepNoise * step)));
  }
  if (tied) {
    foreign_.add(reading.value, reading.value != foreign_.value());
    return Says::leave;
  }
  const std::size_t out = waiting_.count() + 1;  // readings out of the motion
  if (out > WaitingReadings::kMost || (out == kEven && waiting_.goes_on_evenly(reading, far + late())))
    return give_back(reading, relative);
  waiting_.add(reading);
  return Says::wait;
}

double MotionGate::tied_medians(double step) const noexcept {
  const double by_chance = std::min(1.0, static_cast<double>(Recent::kRemembered) * 0.28 *
                                             PredictionErrors::kMedianOfNormal * step / errors_.median());
  if (!(by_chance > kTiedByChance)) return kTied;
  return std::max(kTied, std::sqrt(2 * std::log(by_chance / kTiedByChance)) / PredictionErrors::kMedianOfNormal);
}

MotionGate::Says MotionGate::give_back(const Reading& newest, double relative) noexcept {
  predictor_.restart();
  const std::span<const Reading> back = waiting_.take();
  given_back_ = back.size();
  for (const Reading& reading : back) follow(reading);
  follow(newest);
  errors_.jump(relative);
  return Says::give_back;
}

}  // namespace dwell
