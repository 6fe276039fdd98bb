// Do a channel's readings return to numbers that it has just shown? Two disturbances bring that.
//
// A register that is refreshed every other reading or so, while there are few readings a period: a reading then equals
// the one before far too often. Chance makes a reading equal to the one before no more often than to one of the same
// instant of the period before, for that one differs by noise alone. So where the motion turns after four changes and
// eight readings at most, as many identical readings are expected as there are changes to one of the last kRemembered
// numbers. Those at an extreme are not counted: crests are flat. A third of all readings must be identical, for a
// gateway repeats an answer only now and then; and nine changes of ten must be to a new number, for a coarsely rounded
// motion has few numbers.
//
// A gateway that answers with a reading two or three polls old: a number comes back that was left a moment before, and
// the motion turns there and turns back. A crest that comes down over the same numbers turns once.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/intake/recent_numbers.hpp"

namespace dwell {

// Whether `seen` events are more than chance brings where `expected` are to be expected: passed once in 10^7 (Poisson;
// expected 3: 23 or more, 1e-13; 10: 45, 1e-15).
[[nodiscard]] inline bool beyond_chance(std::int64_t seen, double expected) noexcept {
  return static_cast<double>(seen) > 2 * expected + 6 * std::sqrt(expected) + 6;
}

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RecurringNumbers {
 public:
  static constexpr std::size_t kRemembered = 16;

  // The number `left` was read `run` times; then came another, `reading`. turned: the motion turned at `left`.
  void add(double left, std::int64_t run, double reading, bool turned) noexcept {
    if (turned) ++turns_;
    if (turned && back_) ++returned_;
    if (left < high_ && left > low_) same_inside_ += run - 1;
    high_ = std::max(high_, left);
    low_ = std::min(low_, left);
    remembered_.add(left);
    const bool recurring = remembered_.has(reading);
    if (recurring) ++recurring_;
    back_ = recurring && turned && reading > low_ && reading < high_;
  }

  // Of a motion of few readings a period more are identical than chance brings. pairs: of readings one after the other;
  // changes: those of them that differ.
  [[nodiscard]] bool held_by_few(std::int64_t pairs, std::int64_t changes) const noexcept {
    return 10 * recurring_ < changes && changes <= kFewChanges * turns_ && pairs <= 2 * kFewChanges * turns_ &&
           3 * same_inside_ > pairs && beyond_chance(same_inside_, static_cast<double>(recurring_));
  }

  // How many readings, other than at an extreme, were one of the last numbers again amid a motion that went on: it
  // turned before them and after them.
  [[nodiscard]] std::int64_t returned() const noexcept { return returned_; }

  // Counts begin anew; the newest numbers stay known.
  void restart() noexcept {
    turns_ = recurring_ = returned_ = same_inside_ = 0;
    low_ = INFINITY;
    high_ = -INFINITY;
  }

 private:
  static constexpr std::int64_t kFewChanges = 4;  // from turn to turn

  RecentNumbers<kRemembered> remembered_;  // each but the newest left again
  std::int64_t turns_ = 0, recurring_ = 0, returned_ = 0,
               same_inside_ = 0;  // inside: not at an extreme
  double low_ = INFINITY, high_ = -INFINITY;
  bool back_ = false;  // the newest number is one of those before, and the motion turned before it
};

}  // namespace dwell
