// Counts repeats of a gateway that are too frequent for the motion gate, which takes them for noise.
//
// Only places where the motion is steep count: both jumps beside a reading go the same way and are above the mean. A
// repeat there interrupts the motion. By chance a reading equals the one before as often as differences are 0
// (HeldReadings). Noise has jumps in either direction, less than half of them above the mean. So hardly one in ten of
// its repeats lies at such a place, and none of a motion without noise.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RepeatedAnswers {
 public:
  // A number was read `run` times between two jumps. They count if both are above `least` and above mean().
  template <class Mean>
  void add(std::int64_t run, double before, double after, double least, Mean&& mean) noexcept {
    const double smaller = std::min(std::abs(before), std::abs(after));
    if (!(before * after > 0) || !(smaller > least) || !(smaller > mean())) return;
    places_ += run;
    repeats_ += run - 1;
  }
  // Readings where the motion is steep, and the repeats among them.
  [[nodiscard]] std::int64_t places() const noexcept { return places_; }
  [[nodiscard]] std::int64_t repeats() const noexcept { return repeats_; }
  // Largest part of the repeats by chance that lies where the motion is steep.
  static constexpr double kSteepByChance = 0.1;
  void restart() noexcept { *this = {}; }

 private:
  std::int64_t places_ = 0, repeats_ = 0;
};

}  // namespace dwell
