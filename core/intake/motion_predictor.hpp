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

namespace dwell {

// Of one channel, in any unit. Bound to one thread; real-time safe.
class MotionPredictor {
 public:
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
  [[nodiscard]] bool full() const noexcept { return held_ == kPoints; }
  void restart() noexcept { held_ = 0; }

 private:
  static constexpr std::size_t kPoints = 5, kEven = 6;
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
