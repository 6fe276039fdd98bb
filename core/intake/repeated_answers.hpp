// Does a gateway answer with the reading before, so often that the motion gate takes it for noise?
//
// Where the motion is steep, both jumps beside a reading go the same way and are above the mean. A repeat shows there:
// it interrupts the motion. By chance a reading is the one before again as often as differences are 0 (HeldReadings),
// but of noise, whose jumps go either way and are above the mean less than half of the time, hardly one in ten of these
// lies between two such jumps; of a motion without noise none does.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RepeatedAnswers {
 public:
  // A number was read `run` times, between the jumps `before` and `after`; jumps above `least` and above what mean()
  // gives count.
  template <class Mean>
  void add(std::int64_t run, double before, double after, double least, Mean&& mean) noexcept {
    const double smaller = std::min(std::abs(before), std::abs(after));
    if (!(before * after > 0) || !(smaller > least) || !(smaller > mean())) return;
    places_ += run;
    repeats_ += run - 1;
  }
  // Readings where the motion is steep, and those of them that are the one before again.
  [[nodiscard]] std::int64_t places() const noexcept { return places_; }
  [[nodiscard]] std::int64_t repeats() const noexcept { return repeats_; }
  // Of all readings that are the one before again by chance, at most this part lies where the motion is steep.
  static constexpr double kSteepByChance = 0.1;
  void restart() noexcept { *this = {}; }

 private:
  std::int64_t places_ = 0, repeats_ = 0;
};

}  // namespace dwell
