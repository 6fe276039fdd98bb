// Remembers what the table did, for the messages that say why there is no dwell. It sees windows of a period, one each
// quarter period. Bound to one thread; real-time safe except for functions that return text.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "core/fit/blocks.hpp"
#include "core/fit/mains.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

class SeenDrive {
 public:
  // Resets the ranges that unsteady() tells.
  void arm() noexcept { least_ = INFINITY, most_ = slowest_ = fastest_ = 0.0, windows_ = 0; }
  // Takes one window: the table's amplitude, m (rad), and the frequency so far, Hz (NaN: not known yet). moves: whether
  // the motion is taken for a drive.
  void take(double amplitude, double frequency_hz, bool moves) noexcept {
    newest_ = amplitude;
    largest_ = std::max(largest_, amplitude);
    // The first period may hold the drive's beginning.
    if (!moves || ++windows_ <= kQuarters) return;
    least_ = std::min(least_, amplitude);
    most_ = std::max(most_, amplitude);
    if (!std::isfinite(frequency_hz)) return;
    slowest_ = slowest_ > 0 ? std::min(slowest_, frequency_hz) : frequency_hz;
    fastest_ = std::max(fastest_, frequency_hz);
  }

  // The message for a table that does not count as moving.
  [[nodiscard]] std::string at_rest(const Rig& rig) const;
  // Whether the amplitude since arm() has changed by more than Rig::tolerance.
  [[nodiscard]] bool swings(const Rig& rig) const noexcept {
    return windows_ > kQuarters && most_ - least_ > rig.tolerance * most_;
  }
  // The message for a table that has moved for `seconds` without being steady for long enough. Before a window counts
  // it says that too few periods were seen. sampling: of the table's channel. A harmonic that folds close
  // to the drive (folding.hpp) and beats with it once or more in this time makes a steady drive look so, and is named.
  [[nodiscard]] std::string unsteady(const Rig& rig, double seconds, const SamplingRegularity& sampling) const;

 private:
  [[nodiscard]] std::string folded_beside(const Rig& rig, double seconds, const SamplingRegularity& sampling) const;

  double newest_ = 0.0, largest_ = 0.0;  // amplitudes of all windows ever
  double least_ = INFINITY, most_ = 0.0, slowest_ = 0.0, fastest_ = 0.0;
  int windows_ = 0;
};

}  // namespace dwell
