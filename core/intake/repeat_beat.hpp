// Recognizes a register that is refreshed nearly as often as it is read. It repeats a reading seldom, but with a beat:
// whenever the two rates have slipped by one reading.
//
// It is found after kBeats regular repeats, if rounding is so fine that chance brings fewer than kNoChance (false
// alarm: four where 0.03 are expected, 3e-8). Repeats at a turning point come in time with the motion. So chance is
// computed for the smallest jump beside the repeats, and one repeat must interrupt the motion.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/intake/repeat_distances.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RepeatBeat {
 public:
  // Another reading.
  void next() noexcept {
    since_ += 1.0;
    if (found_ && since_ > kSilent * beat_) found_ = false;
  }
  // So many readings, none of which ends a repeat. Only while nothing is found.
  void pass(std::size_t readings) noexcept { since_ += static_cast<double>(readings); }
  // The newest reading ends a repeat between two jumps; beside: the smaller of them. onwards: both go the same way.
  // step: of the rounding. density: of the differences near 0, per `beside`.
  void repeat(bool onwards, double beside, double step, double density) noexcept {
    if (since_ < RepeatDistances::kBunch * beat_ && beat_ >= kSlowest) return;
    const double times = std::max(1.0, std::round(since_ / std::max(1.0, beat_)));
    const bool regular =
        beat_ >= kSlowest && times <= kMissed && std::abs(since_ - times * beat_) <= RepeatDistances::kRegular * beat_;
    if (!regular) regular_ = onwards_ = 0, beat_ = since_, beside_ = beside;
    since_ = 0.0;
    if (!regular) return;
    ++regular_;
    beside_ = std::min(beside_, beside);
    if (onwards) ++onwards_;
    const double by_chance = density * beat_ * (regular_ + 1) * step / beside_;
    if (onwards_ > 0 && regular_ >= kBeats && by_chance < kNoChance) found_ = true;
  }
  [[nodiscard]] bool found() const noexcept { return found_; }
  // The latest repeats come with a beat.
  [[nodiscard]] bool suspected() const noexcept { return regular_ > 0; }

 private:
  // kSlowest: least beat, in readings; in a shorter one whole runs are many. kSilent: beats without a repeat after
  // which nothing is found any more.
  static constexpr double kSlowest = 30.0, kSilent = 3.0;
  static constexpr double kNoChance = 0.03;
  static constexpr int kBeats = 3, kMissed = 3;
  double since_ = 0.0, beat_ = 0.0;  // readings
  double beside_ = 0.0;              // smallest jump beside the latest repeats
  int regular_ = 0, onwards_ = 0;    // regular repeats in a row; those amid a motion
  bool found_ = false;
};

}  // namespace dwell
