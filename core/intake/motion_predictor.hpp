// Predicts the next reading from the last kPoints good ones.
//
// Least squares through them, at their own instants, of a mean, a sine and a cosine at the drive's frequency. This
// follows any motion that is smooth over kPoints readings, whatever its frequency.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace dwell {

// Of one channel, in any unit. Bound to one thread; real-time safe.
class MotionPredictor {
 public:
  static constexpr std::size_t kPoints = 5;
  // gain: standard deviation of the prediction's error for white noise of 1; 0: no prediction.
  struct Prediction {
    double value = 0.0, gain = 0.0;
  };
  // The prediction for t_ns. before_ns: the instant of the reading before, good or not; omega: rad/s.
  [[nodiscard]] Prediction predict(std::int64_t t_ns, std::int64_t before_ns, double omega) noexcept;
  // The largest absolute slope, per s, between neighbouring points and from the newest one to the prediction for t_ns.
  [[nodiscard]] double slope(const Prediction& predicted, std::int64_t t_ns) const noexcept;
  // A good reading.
  void add(std::int64_t t_ns, double value) noexcept {
    const std::int64_t gap_ns = t_ns - points_.back().t_ns;
    if (gap_ns != gap_ns_) {
      gap_ns_ = gap_ns;
      even_ = 1;
    } else if (even_ < kPoints) {
      ++even_;
    }
    std::move(points_.begin() + 1, points_.end(), points_.begin());
    points_.back() = {t_ns, value};
    if (held_ < kPoints) ++held_;
  }
  // Whether the points are these numbers, evenly spaced up to before_ns, and their weights are known for a reading that
  // comes as evenly. Then predict_evenly() gives what predict() would.
  [[nodiscard]] bool even(std::span<const double, kPoints> numbers, std::int64_t before_ns,
                          double omega) const noexcept {
    bool same = full() && even_ + 1 >= kPoints && weights_.gap_ns == gap_ns_ && weights_.omega == omega &&
                weights_.gain > 0 && points_.back().t_ns == before_ns;
    for (std::size_t j = 0; j < kPoints; ++j) same &= points_[j].value == numbers[j];
    return same;
  }
  [[nodiscard]] std::int64_t gap_ns() const noexcept { return gap_ns_; }
  [[nodiscard]] double even_gain() const noexcept { return weights_.gain; }
  // The reading after these; only while even().
  [[nodiscard]] double predict_evenly(const double* numbers) const noexcept {
    double value = 0.0;
    for (std::size_t j = 0; j < kPoints; ++j) value += weights_.of_point[j] * numbers[j];
    return value;
  }
  // As add() for so many good readings, evenly spaced up to last_ns; numbers: the last kPoints of all.
  void add_evenly(std::size_t readings, std::int64_t last_ns, std::span<const double, kPoints> numbers) noexcept {
    even_ = std::min(even_ + readings, kPoints);
    for (std::size_t j = 0; j < kPoints; ++j)
      points_[j] = {last_ns - gap_ns_ * static_cast<std::int64_t>(kPoints - 1 - j), numbers[j]};
  }
  [[nodiscard]] bool full() const noexcept { return held_ == kPoints; }
  void restart() noexcept { held_ = 0; }

 private:
  static constexpr std::size_t kEven = 6;
  static constexpr double kSparse = 1.2;  // rad between readings: with fewer than 5 a period there is no prediction
  static constexpr double kPause = 3.0;   // mean intervals: readings were lost
  static constexpr double kBlind = 2.0;   // rad since the last good reading: beyond, there is no prediction
  struct Point {
    std::int64_t t_ns = 0;
    double value = 0.0;
  };
  // The points' weights in the prediction. Only their instants and ω determine them.
  struct Weights {
    double omega = 0.0;                          // 0: not computed yet
    std::int64_t gap_ns = 0;                     // from point to point and to the predicted instant; 0: they differ
    std::array<std::int64_t, kPoints> ago_ns{};  // if they differ: less the predicted instant
    std::array<double, kEven> of_point{};        // those beyond kPoints are unused
    double interval = 0.0, gain = 0.0;           // rad, mean distance of the points; 0: no prediction
  };
  void weigh(double omega) noexcept;

  std::array<Point, kPoints> points_{};  // the newest last
  std::size_t held_ = 0;
  std::int64_t gap_ns_ = 0;  // between the newest two points
  std::size_t even_ = 0;     // the newest gaps that equal it, itself included; at most kPoints
  Weights weights_;          // sampled evenly they stay the same
};

}  // namespace dwell
