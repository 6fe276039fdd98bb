// Finds out whether a channel's readings return to numbers that it has just shown. Two disturbances do that.
//
// A register refreshed about every other reading, with few readings a period: far too often a reading equals the one
// before. By chance that is no more frequent than a reading that equals the one a period before, which differs by noise
// alone. So the changes to one of the last kRemembered numbers give the expected count, if the motion turns after four
// changes and eight readings at most. Crests are flat: readings at an extreme do not count. A third of all readings
// must be identical, since a gateway repeats an answer only now and then. Nine changes of ten must be to a new number,
// since a coarsely rounded motion has few numbers.
//
// A gateway that answers with a reading two or three polls old: the motion turns to a number that it has just left, and
// turns back. A crest that comes down over the same numbers turns once.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/intake/recent_numbers.hpp"

namespace dwell {

// Whether `seen` events are more than chance brings where `expected` are expected. Passed by chance once in 10^7
// (Poisson; expected 3: 23 or more, 1e-13; 10: 45, 1e-15).
[[nodiscard]] inline bool beyond_chance(std::int64_t seen, double expected) noexcept {
  return static_cast<double>(seen) > 2 * expected + 6 * std::sqrt(expected) + 6;
}

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class RecurringNumbers {
 public:
  static constexpr std::size_t kRemembered = 16;

  // `left` was read `run` times; then came another number, `reading`. turned: the motion turned at `left`.
  void add(double left, std::int64_t run, double reading, bool turned) noexcept {
    if (turned) ++turns_;
    if (turned && back_) ++returned_;
    if (left < high_ && left > low_) same_inside_ += run - 1;
    high_ = std::max(high_, left);
    low_ = std::min(low_, left);
    const bool recurring = remembered_.has(reading);  // `left` itself is another number
    remembered_.add(left);
    if (recurring) ++recurring_;
    back_ = recurring && turned && reading > low_ && reading < high_;
  }

  // Whether `same_inside_` is far too small for held_by_few(), now and with more pairs.
  [[nodiscard]] bool hardly_repeats(std::int64_t pairs) const noexcept { return 3 * same_inside_ <= pairs; }
  // Whether the newest number has just come back.
  [[nodiscard]] bool back() const noexcept { return back_; }
  // The numbers left last, the oldest first.
  void copy_to(std::span<double, kRemembered - 1> numbers) const noexcept { remembered_.copy_to(numbers); }
  // As add() for a number that does not recur, once read, where none came back before. Call end_passing() after the
  // last one of a run.
  void pass(bool turned) noexcept { turns_ += turned ? 1 : 0; }
  // left: the numbers that were left in the run; low, high: their range.
  void end_passing(std::span<const double> left, double low, double high) noexcept {
    high_ = std::max(high_, high);
    low_ = std::min(low_, low);
    remembered_.add_all(left);
    back_ = false;
  }

  // Whether a register is held: with few readings a period, more are identical than chance brings. pairs: of
  // consecutive readings; changes: pairs that differ.
  [[nodiscard]] bool held_by_few(std::int64_t pairs, std::int64_t changes) const noexcept {
    // First what nearly every channel fails.
    return 3 * same_inside_ > pairs && 10 * recurring_ < changes && changes <= kFewChanges * turns_ &&
           pairs <= 2 * kFewChanges * turns_ && beyond_chance(same_inside_, static_cast<double>(recurring_));
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
  static constexpr std::int64_t kFewChanges = 4;  // largest number from turn to turn

  // The numbers left last. The newest one need not be among them when has() is asked: `reading` differs from it.
  RecentNumbers<kRemembered - 1> remembered_;
  std::int64_t turns_ = 0, recurring_ = 0, returned_ = 0,
               same_inside_ = 0;  // inside: not at an extreme
  double low_ = INFINITY, high_ = -INFINITY;
  bool back_ = false;  // the newest number is one of the last, not at an extreme, and the motion turned before it
};

}  // namespace dwell
