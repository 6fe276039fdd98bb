// Repeats in time with a beat: a register that is refreshed nearly as often as it is read repeats a reading seldom, but
// whenever the two rates have slipped by one reading.
//
// Where rounding is so fine that chance brings none (fewer than kNoChance), kBeats repeats at regular distances tell
// (false alarm: four where 0.03 are expected, 3e-8). Repeats at a turning point come in time with the motion: what
// chance brings is counted for the smallest of the jumps beside the repeats, and one of them must interrupt the motion.
#pragma once

#include <algorithm>
#include <cmath>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RepeatBeat {
 public:
  // Another reading.
  void next() noexcept {
    if (++since_ > kSilent * beat_) found_ = false;
  }
  // The newest reading ends a repeat that lies between two jumps, the smaller of them `beside`. onwards: both go the
  // same way. step: of the rounding. density: of the differences near 0, per `beside`.
  void repeat(bool onwards, double beside, double step, double density) noexcept {
    if (since_ < kBunch * beat_ && beat_ >= kSlowest) return;
    const double times = std::max(1.0, std::round(since_ / std::max(1.0, beat_)));
    const bool regular = beat_ >= kSlowest && times <= kMissed && std::abs(since_ - times * beat_) <= kRegular * beat_;
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
  // The latest repeats come in time.
  [[nodiscard]] bool suspected() const noexcept { return regular_ > 0; }

 private:
  // The least distance, in readings (below, whole runs are many); how regular, relative (a gateway's random repeats are
  // so once in eight); so many in a row, not counting the first two. Where instants jitter, a beat is a bunch of
  // repeats.
  static constexpr double kSlowest = 30.0, kRegular = 0.12, kBunch = 0.3, kSilent = 3.0;
  static constexpr double kNoChance = 0.03;
  static constexpr int kBeats = 3, kMissed = 3;
  double since_ = 0.0, beat_ = 0.0;  // readings
  double beside_ = 0.0;              // smallest jump beside the repeats
  int regular_ = 0, onwards_ = 0;    // repeats in a row, and those of them amid a motion
  bool found_ = false;
};

}  // namespace dwell
