// What will the next reading be, by the last kPoints good ones?
//
// A mean, a sine and a cosine at the drive's frequency through them, by least squares, at their own instants. That
// follows any motion that is smooth over kPoints readings, whatever its frequency.
#pragma once

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
  [[nodiscard]] Prediction predict(std::int64_t t_ns, std::int64_t before_ns, double omega) const noexcept;
  // A good reading.
  void add(std::int64_t t_ns, double value) noexcept {
    points_[next_] = {t_ns, value};
    next_ = (next_ + 1) % kPoints;
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
  std::array<Point, kPoints> points_{};  // the newest at (next_ - 1) % kPoints
  std::size_t next_ = 0, held_ = 0;
};

}  // namespace dwell
