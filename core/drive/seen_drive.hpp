// What the table was seen to do, for people: when no dwell comes of it, they are told what it did instead.
// Windows of a period, one each quarter. Bound to one thread; real-time safe but for the text.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "core/rig/rig.hpp"

namespace dwell {

class SeenDrive {
 public:
  // A drive begins to be looked at.
  void arm() noexcept { least_ = INFINITY, most_ = slowest_ = fastest_ = 0.0, windows_ = 0; }
  // One window: the table's amplitude, m (rad), and its frequency so far, Hz; NaN: not known yet. moves: whether it is
  // taken for a drive at all.
  void take(double amplitude, double frequency_hz, bool moves) noexcept {
    newest_ = amplitude;
    largest_ = std::max(largest_, amplitude);
    // The first period may hold the beginning.
    if (!moves || ++windows_ <= kFirst) return;
    least_ = std::min(least_, amplitude);
    most_ = std::max(most_, amplitude);
    if (!std::isfinite(frequency_hz)) return;
    slowest_ = slowest_ > 0 ? std::min(slowest_, frequency_hz) : frequency_hz;
    fastest_ = std::max(fastest_, frequency_hz);
  }

  // Of a table that does not count as moving.
  [[nodiscard]] std::string at_rest(const Rig& rig) const;
  // Of one that has moved for so long without being steady for long enough.
  [[nodiscard]] std::string unsteady(const Rig& rig, double seconds) const;

 private:
  static constexpr int kFirst = 4;       // windows of a period
  double newest_ = 0.0, largest_ = 0.0;  // of all that was ever seen
  double least_ = INFINITY, most_ = 0.0, slowest_ = 0.0, fastest_ = 0.0;
  int windows_ = 0;
};

}  // namespace dwell
