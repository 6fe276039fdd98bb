#include "core/intake/motion_gate.hpp"

#include <algorithm>

namespace dwell {
namespace {

constexpr std::size_t kEven = 3;                     // readings in a row that go on evenly are another motion
constexpr double kStepNoise = 0.29;                  // standard deviation of rounding, steps: 1 / √12
constexpr double kMedianOfNormal = 0.6745;           // of |x|, in standard deviations
constexpr double kTied = 3.0, kTiedByChance = 1e-8;  // in medians, the least k; see the header
constexpr double kTiedRounding = 2.5;
constexpr double kRefresh = 5.0;  // 1 + Σ|w|: the instants of the points are as uncertain
// Largest half width times slope with which a held-up answer still counts, in standard deviations of the noise: √6. An
// error evenly distributed over ± √6 σ has the variance 2 σ². Smaller: answers that would help are left out.
constexpr double kUncertain = 2.449;
// Medians of the half widths. Exponentially distributed delays exceed it in 3 % (2⁻⁵).
constexpr double kByFar = 5.0;
constexpr double kRare = 0.1;    // part of the readings: to leave out fewer widens u by at most 5 %
constexpr double kJumped = 6.0;  // after a jump the median is at least its error over this

}  // namespace

double MotionGate::noise() const noexcept { return seen_ > kFewest ? median_ / kMedianOfNormal : 0.0; }

MotionGate::Says MotionGate::judge(const Reading& reading, double omega, double step) noexcept {
  given_back_ = 0;
  const MotionPredictor::Prediction predicted = predictor_.predict(reading.t_ns, last_ns_, omega);
  last_ns_ = reading.t_ns;
  const bool tied = recent_.has(reading.value) || (foreign_.cluster() && reading.value == foreign_.value());
  if (recent_.newest() != reading.value) recent_.add(reading.value);
  if (median_half_ns_ == 0.0) median_half_ns_ = reading.half_ns;
  // The first reading may be a late one: at first the median moves five times as fast.
  const double learn = seen_ <= kFewest ? 5 * kLearn : kLearn;
  median_half_ns_ *= reading.half_ns > median_half_ns_ ? 1 + learn : 1 - learn;
  active_ = predicted.gain > 0 && std::isfinite(step) && seen_ > kFewest;
  const auto counts = [&](bool certain) {
    if (certain) return Says::take;
    ++uncertain_;
    ++uncertain_in_hold_;
    return Says::uncertain;
  };
  const bool by_far = reading.half_ns > kByFar * median_half_ns_;
  if (by_far || by_far_ > 0) by_far_ += kLearnRare * ((by_far ? 1.0 : 0.0) - by_far_);
  if (!(predicted.gain > 0) || !std::isfinite(step)) {
    if (predictor_.full()) predictor_.restart();  // a pause, or too few readings a period: begin anew
    for (std::size_t i = 0; i < waits_; ++i) foreign_.add(waiting_[i].value, false);
    waits_ = 0;
    follow(reading);
    return counts(!by_far);
  }
  const double error = std::abs(reading.value - predicted.value), relative = error / predicted.gain;
  if (seen_ <= kFewest) {
    ++seen_;
    median_ =
        seen_ <= 8 ? std::max(median_, relative) : median_ * (relative > median_ ? 1 + 5 * kLearn : 1 - 5 * kLearn);
    follow(reading);
    return counts(!by_far);
  }
  const double far = predicted.gain * kFar * median_ + kRounding * step;
  const double limit = tied ? predicted.gain * tied_medians(step) * median_ + kTiedRounding * step : far;
  // The instant's half width only raises a limit. Few readings need it, and it costs a division.
  const auto moves = [&](double half_ns) { return predictor_.slope(predicted, reading.t_ns) * 1e-9 * half_ns; };
  const auto late = [&] { return moves(reading.half_ns + kRefresh * reading.refresh_half_ns); };
  if (error <= limit || error <= limit + late()) {
    for (std::size_t i = 0; i < waits_; ++i) foreign_.add(waiting_[i].value, false);
    waits_ = 0;
    median_ *= kTowards[relative > median_ ? 1 : 0];
    follow(reading);
    const bool rare = by_far && by_far_ < kRare;
    return counts(!held_up(reading) ||
                  (!rare && moves(reading.half_ns) <= kUncertain * std::max(noise(), kStepNoise * step)));
  }
  if (tied) {
    foreign_.add(reading.value, reading.value != foreign_.value());
    return Says::leave;
  }
  if (waits_ + 1 == kMost || (waits_ + 1 == kEven && even(reading, far + late()))) return give_back(reading, relative);
  waiting_[waits_++] = reading;
  return Says::wait;
}

double MotionGate::tied_medians(double step) const noexcept {
  const double by_chance =
      std::min(1.0, static_cast<double>(Recent::kRemembered) * 0.28 * kMedianOfNormal * step / median_);
  if (!(by_chance > kTiedByChance)) return kTied;
  return std::max(kTied, std::sqrt(2 * std::log(by_chance / kTiedByChance)) / kMedianOfNormal);
}

MotionGate::Says MotionGate::give_back(const Reading& newest, double relative) noexcept {
  given_back_ = waits_;
  predictor_.restart();
  for (std::size_t i = 0; i < given_back_; ++i) follow(waiting_[i]);
  follow(newest);
  waits_ = 0;
  median_ = std::max(median_, relative / kJumped);
  return Says::give_back;
}

// Whether the waiting readings and the newest go on evenly: on a line to within the gate's limit, or with differences
// that change by no more than half.
bool MotionGate::even(const Reading& newest, double limit) const noexcept {
  const double before = waiting_[waits_ - 1].value - waiting_[waits_ - 2].value,
               after = newest.value - waiting_[waits_ - 1].value;
  return std::abs(after - before) <= std::max(limit, 0.5 * (std::abs(after) + std::abs(before)));
}

}  // namespace dwell
