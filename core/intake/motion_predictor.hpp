// What will the next reading be, by the last kPoints good ones?
//
// A mean, a sine and a cosine at the drive's frequency through them, by least squares, at their own instants. That
// follows any motion that is smooth over kPoints readings, whatever its frequency.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Of one channel, in any unit. Bound to one thread; real-time safe.
class MotionPredictor {
 public:
  // gain: standard deviation of the prediction's error for white noise of 1; 0: nothing can be predicted. slope: per s.
  struct Prediction {
    double value = 0.0, gain = 0.0, slope = 0.0;
  };
  // At t_ns; before_ns: the instant of the reading before, good or not; ω in rad/s.
  [[nodiscard]] Prediction predict(std::int64_t t_ns, std::int64_t before_ns, double omega) noexcept;
  // A good reading.
  void add(std::int64_t t_ns, double value) noexcept {
    std::move(points_.begin() + 1, points_.end(), points_.begin());
    points_.back() = {t_ns, value};
    if (held_ < kPoints) ++held_;
  }
  [[nodiscard]] bool full() const noexcept { return held_ == kPoints; }
  void restart() noexcept { held_ = 0; }

 private:
  static constexpr std::size_t kPoints = 5, kEven = 6;
  static constexpr double kSparse = 1.2;  // rad between readings: fewer than 5 a period predict nothing
  static constexpr double kPause = 3.0;   // mean intervals: readings were lost
  static constexpr double kBlind = 2.0;   // rad since the last good reading: nothing is predicted any more
  struct Point {
    std::int64_t t_ns = 0;
    double value = 0.0;
  };
  // What the points weigh in the prediction, which their instants and ω tell.
  struct Weights {
    double omega = 0.0;                          // 0: of nothing yet
    std::array<std::int64_t, kPoints> ago_ns{};  // before the instant that is predicted
    std::array<double, kEven> of_point{};        // beyond kPoints: of no meaning
    double interval = 0.0, gain = 0.0;           // mean distance of the points, rad; 0: nothing can be predicted
  };
  void weigh(double omega) noexcept;

  std::array<Point, kPoints> points_{};  // the newest last
  std::size_t held_ = 0;
  Weights weights_;  // evenly sampled, they stay as they are
};

}  // namespace dwell
