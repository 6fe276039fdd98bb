// Finds spikes: single readings far from all others of their channel, as of a load cell, or of a register read while it
// was written. One among ten thousand outweighs the noise of all, and least squares never forget it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dwell {

// Of one channel. One thread; a few comparisons a reading.
class SpikeGate {
 public:
  // Whether this reading lies outside the range of this period and the last by more than 1.5 times that range, as no
  // harmonic motion does. false if the two readings before did as well: then it is another motion. Any unit.
  bool spike(double value) noexcept {
    if (value >= now_.low && value <= now_.high) {  // most readings: within this period's range, which stays
      in_row_ = 0;
      ++now_.count;
      return false;
    }
    const double low = std::min(before_.low, now_.low), high = std::max(before_.high, now_.high);
    const double room = kRoom * (high - low);
    if (before_.count >= kFewest && room > 0 && (value < low - room || value > high + room) && in_row_ < kMostInRow) {
      ++in_row_;
      return true;
    }
    in_row_ = 0;
    now_.low = std::min(now_.low, value);
    now_.high = std::max(now_.high, value);
    ++now_.count;
    return false;
  }
  // No reading between these is a spike, however many come; both NaN: not known.
  struct Bounds {
    double low, high;
  };
  [[nodiscard]] Bounds bounds() const noexcept {
    const double low = std::min(before_.low, now_.low), high = std::max(before_.high, now_.high);
    const double room = kRoom * (high - low);
    if (before_.count < kFewest || !(room > 0)) return {NAN, NAN};
    return {low - room, high + room};
  }
  // So many readings, none of them a spike; their range.
  void add_good(std::size_t readings, double low, double high) noexcept {
    in_row_ = 0;
    now_.low = std::min(now_.low, low);
    now_.high = std::max(now_.high, high);
    now_.count += static_cast<long>(readings);
  }
  void next_period() noexcept {
    before_ = now_;
    now_ = {};
  }

 private:
  static constexpr double kRoom = 1.5;
  static constexpr int kFewest = 4, kMostInRow = 2;
  struct Seen {
    double low = INFINITY, high = -INFINITY;
    long count = 0;
  };
  Seen now_, before_;
  int in_row_ = 0;
};

}  // namespace dwell
