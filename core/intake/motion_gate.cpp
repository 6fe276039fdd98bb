#include "core/intake/motion_gate.hpp"

#include <algorithm>

#include "core/fit/moments.hpp"

namespace dwell {

MotionGate::Prediction MotionGate::predict(std::int64_t t_ns, double omega) const noexcept {
  if (points_held_ < kPoints) return {};
  // Instants before t_ns, rad; h, their mean distance, scales the regressors 1, sin x / h, (1 - cos x) / h² to like
  // sizes, however densely the motion is sampled.
  std::array<double, kPoints> x;
  for (std::size_t j = 0; j < kPoints; ++j)
    x[j] = 1e-9 * omega * static_cast<double>(points_[(next_point_ + j) % kPoints].t_ns - t_ns);
  const double h = (x[kPoints - 1] - x[0]) / (kPoints - 1);
  if (!(h > 0) || h > kSparse || -x[kPoints - 1] > kBlind) return {};
  if (1e-9 * omega * static_cast<double>(t_ns - last_ns_) > kPause * h) return {};
  std::array<double, kPoints> s, c;
  double m01 = 0, m02 = 0, m11 = 0, m12 = 0, m22 = 0;
  for (std::size_t j = 0; j < kPoints; ++j) {
    // Half the angle's sine and cosine: accurate however small it is.
    double sine, cosine;
    moments::sin_cos(0.5 * x[j], sine, cosine);
    s[j] = 2 * sine * cosine / h;
    c[j] = 2 * sine * sine / (h * h);
    m01 += s[j];
    m02 += c[j];
    m11 += s[j] * s[j];
    m12 += s[j] * c[j];
    m22 += c[j] * c[j];
  }
  // At t_ns the regressors are (1, 0, 0): the first column of the inverse gives the weights.
  const double m00 = kPoints;
  const double a00 = m11 * m22 - m12 * m12, a01 = m12 * m02 - m01 * m22, a02 = m01 * m12 - m11 * m02;
  const double determinant = m00 * a00 + m01 * a01 + m02 * a02;
  if (!(determinant > 1e-6 * m00 * m11 * m22)) return {};
  Prediction out;
  double squares = 1.0;
  for (std::size_t j = 0; j < kPoints; ++j) {
    const double weight = (a00 + a01 * s[j] + a02 * c[j]) / determinant;
    out.value += weight * points_[(next_point_ + j) % kPoints].value;
    squares += weight * weight;
  }
  const Reading& newest = points_[(next_point_ + kPoints - 1) % kPoints];
  out.gain = std::sqrt(squares);
  out.slope = std::abs(out.value - newest.value) / (1e-9 * static_cast<double>(t_ns - newest.t_ns));
  return out;
}

MotionGate::Says MotionGate::judge(const Reading& reading, double omega, double step) noexcept {
  given_back_ = 0;
  const Prediction predicted = predict(reading.t_ns, omega);
  last_ns_ = reading.t_ns;
  const bool tied = recent(reading.value) || (foreign_.commonest >= 2 && reading.value == foreign_.value);
  if (recent_[(next_recent_ + kRecent - 1) % kRecent] != reading.value) {
    recent_[next_recent_] = reading.value;
    next_recent_ = (next_recent_ + 1) % kRecent;
  }
  active_ = predicted.gain > 0 && std::isfinite(step) && seen_ > kFewest;
  if (!(predicted.gain > 0) || !std::isfinite(step)) {
    if (points_held_ >= kPoints) points_held_ = 0;  // a pause, or too few readings a period: begin anew
    for (std::size_t i = 0; i < waits_; ++i) count_foreign(waiting_[i].value, false);
    waits_ = 0;
    take(reading);
    return Says::take;
  }
  const double error = std::abs(reading.value - predicted.value), relative = error / predicted.gain;
  if (seen_ <= kFewest) {
    ++seen_;
    median_ =
        seen_ <= 8 ? std::max(median_, relative) : median_ * (relative > median_ ? 1 + 5 * kLearn : 1 - 5 * kLearn);
    take(reading);
    return Says::take;
  }
  const double late =
      predicted.slope * 1e-9 * (static_cast<double>(reading.half_ns) + kRefresh * reading.refresh_half_ns);
  const double far = predicted.gain * kFar * median_ + kRounding * step + late;
  const double limit = tied ? predicted.gain * tied_medians(step) * median_ + kTiedRounding * step + late : far;
  if (error <= limit) {
    for (std::size_t i = 0; i < waits_; ++i) count_foreign(waiting_[i].value, false);
    waits_ = 0;
    median_ *= relative > median_ ? 1 + kLearn : 1 - kLearn;
    take(reading);
    return Says::take;
  }
  if (tied) {
    count_foreign(reading.value, reading.value != foreign_.value);
    return Says::leave;
  }
  if (waits_ + 1 == kMost || (waits_ + 1 == kEven && even(reading, far))) return give_back(reading, relative);
  waiting_[waits_++] = reading;
  return Says::wait;
}

double MotionGate::tied_medians(double step) const noexcept {
  const double by_chance = std::min(1.0, kRecent * 0.28 * 0.6745 * step / median_);
  if (!(by_chance > kTiedByChance)) return kTied;
  return std::max(kTied, std::sqrt(2 * std::log(by_chance / kTiedByChance)) / 0.6745);
}

MotionGate::Says MotionGate::give_back(const Reading& newest, double relative) noexcept {
  given_back_ = waits_;
  points_held_ = 0;
  for (std::size_t i = 0; i < given_back_; ++i) take(waiting_[i]);
  take(newest);
  waits_ = 0;
  median_ = std::max(median_, relative / kJumped);
  return Says::give_back;
}

// Whether those that wait and the newest go on evenly: on a line as far as the gate's limit tells, or their differences
// change by no more than half.
bool MotionGate::even(const Reading& newest, double limit) const noexcept {
  const double before = waiting_[waits_ - 1].value - waiting_[waits_ - 2].value,
               after = newest.value - waiting_[waits_ - 1].value;
  return std::abs(after - before) <= std::max(limit, 0.5 * (std::abs(after) + std::abs(before)));
}

bool MotionGate::recent(double value) const noexcept {
  return std::find(recent_.begin(), recent_.end(), value) != recent_.end();
}

void MotionGate::take(const Reading& reading) noexcept {
  points_[next_point_] = reading;
  next_point_ = (next_point_ + 1) % kPoints;
  points_held_ = std::min(points_held_ + 1, kPoints);
}

void MotionGate::count_foreign(double value, bool repeat) noexcept {
  ++foreign_.all;
  ++left_;
  if (repeat) ++foreign_.repeats;
  // The commonest value by majority vote (Boyer and Moore).
  if (value == foreign_.value) {
    ++foreign_.commonest;
  } else if (foreign_.commonest <= 1) {
    foreign_.value = value;
    foreign_.commonest = 1;
  } else if (!repeat) {
    --foreign_.commonest;
  }
}

}  // namespace dwell
