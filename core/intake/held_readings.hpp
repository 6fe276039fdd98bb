// Does the device refresh its register more slowly than it is read? Then runs of identical readings end in a jump.
//
// Only runs count that interrupt a motion: both the jump before and the jump after go the same way, by more than two
// rounding steps each. Readings of a turning point, of an element that sticks, of a clipped crest turn back after the
// run; readings of a motion slower than the rounding go on by one step.
//
// How many such readings would chance bring? Differences of a smooth motion with noise have a density near 0 that no
// rounding resolves: as many are 0 as are one step up, and as one step down. The step is taken as the third smallest
// difference seen, which is never below the device's own, wherever its readings were rounded a second time. So E, half
// the number of those within 1.5 steps, is expected; on top of it, for densities that rise towards 0, kDensity of all
// changes times the step over the mean jump (a sine 0.20, Gaussian noise 0.32, a decaying sine up to 0.5). Twice E and
// 6 √E + 6 more are passed by chance less than once in 10^7 holds (Poisson; E = 3: 23 or more, 1e-13; E = 10: 45,
// 1e-15).
//
// A register that is refreshed nearly as often as it is read repeats a reading seldom, but in time with the beat of the
// two rates. Where rounding is so fine that chance brings none (E below kNoChance), kBeats repeats at regular distances
// tell (false alarm: four where 0.03 are expected, 3e-8). Repeats at a turning point come in time with the motion: E is
// for the smallest of the jumps beside the repeats, and one of them must interrupt the motion.
//
// A register that is refreshed three, four or five times a period shows the same few numbers over and over: its
// smallest jump is no rounding step, and none interrupts the motion. There the runs themselves tell: kEvenRuns in a row
// of kLeastRun readings or more that differ by one at most, and kReversals jumps among them that go back by another
// size than the jump before. Of a motion as coarse as its rounding steps runs may be as even, but it goes back over the
// same step, however unequal a second rounding has made the steps. (Noise makes a run of three or more one of two
// lengths at most one time in four: so many in a row once in 10⁵ holds of 10⁴ runs.)
//
// A register that is refreshed every other reading or so while there are few readings a period has no such runs. But
// chance makes a reading equal to the one before no more often than to one of the same instant of the period before:
// that one differs by noise alone. So where the motion turns after four changes and eight readings at most, the
// changes to one of the last kRemembered numbers are E for all identical readings that are not at an extreme. A third
// of all readings must be such, so that a gateway's now and then repeated answers are none; and nine changes of ten
// must be to a new number, so that no coarse rounding is taken for it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class HeldReadings {
 public:
  // The next reading, and the step of its rounding (0: none; INFINITY: not known). Whether it is the same as the one
  // before.
  bool add(double reading, double grid) noexcept {
    const double jump = reading - value_;
    if (std::isnan(value_)) {
      value_ = reading;
      return false;
    }
    ++pairs_;
    if (++since_beat_ > kSilent * beat_) beats_ = false;
    if (jump == 0) {
      ++run_;
      ++same_;
      return true;
    }
    const double size = std::abs(jump), least = kJump * step();
    see_run(jump);
    see_number(reading, jump);
    path_ += size;
    see(size);
    if (run_ > 1 && std::abs(before_) > least && size > least) {
      const bool onwards = before_ * jump > 0;
      if (onwards) interrupting_ += run_ - 1;
      see_beat(onwards, std::min(std::abs(before_), size), grid);
    }
    before_ = jump;
    value_ = reading;
    run_ = 1;
    judge();
    return false;
  }

  // Of the newest reading: how many are identical up to it.
  [[nodiscard]] std::int64_t run() const noexcept { return run_; }
  // Mean difference of two readings one after the other; 0: nothing is known.
  [[nodiscard]] double mean_difference() const noexcept {
    return pairs_ > 0 ? path_ / static_cast<double>(pairs_) : 0.0;
  }
  // The third smallest difference that is not 0, at least the rounding step; INFINITY: not known.
  [[nodiscard]] double step() const noexcept { return smallest_[2]; }
  // There are such readings at all: those from here on are looked at.
  [[nodiscard]] bool suspected() const noexcept { return interrupting_ > 0 || regular_ > 0; }
  // The register is refreshed more slowly than it is read.
  [[nodiscard]] bool held() const noexcept { return held_; }
  // Mean number of readings per refresh. The refresh interval is this times the polling interval.
  [[nodiscard]] double reads_each() const noexcept {
    return static_cast<double>(pairs_) / std::max(1.0, static_cast<double>(pairs_ - same_));
  }

  // How many readings, other than at an extreme, are one of the last numbers again, where that is more than chance
  // brings; 0: it is not. Of a motion that takes more than 2 kRemembered readings a period: of others numbers come back
  // with each period. By chance: kDensity of all changes times the step over the mean jump, for each number remembered.
  [[nodiscard]] std::int64_t older_again() const noexcept {
    const auto changes = static_cast<double>(pairs_ - same_);
    if (changes < 3) return 0;
    const double expected = static_cast<double>(kRemembered) * kDensity * changes * changes * step() / path_;
    return beyond_chance(recurring_inside_, expected) ? recurring_inside_ : 0;
  }
  static constexpr std::size_t kRemembered = 16;

  // A new hold of the drive: counts begin anew. What was found stands until as much is seen again.
  void restart() noexcept {
    pairs_ = same_ = one_step_ = interrupting_ = 0;
    even_runs_ = reversals_ = 0;
    turns_ = recurring_ = recurring_inside_ = same_inside_ = 0;
    low_ = INFINITY;
    high_ = -INFINITY;
    path_ = 0.0;
    smallest_ = {INFINITY, INFINITY, INFINITY};
  }

 private:
  static constexpr double kJump = 2.5, kDensity = 0.5;
  // What was found before a hold is dropped after so many pairs with fewer such readings.
  static constexpr std::int64_t kEnough = 4096, kHardlyAny = 8;
  // Beats: the least distance, in readings (below, the readings above are many); how regular, relative (a gateway's
  // random repeats are so once in eight); so many in a row, not counting the first two. Where instants jitter, a beat
  // is a bunch of repeats.
  static constexpr double kSlowBeat = 30.0, kRegular = 0.12, kBunch = 0.3, kSilent = 3.0;
  static constexpr double kNoChance = 0.03, kSameStep = 0.9;
  static constexpr int kBeats = 3, kMissedBeats = 3;
  static constexpr int kEvenRuns = 16, kReversals = 3;
  static constexpr std::int64_t kLeastRun = 3;
  static constexpr double kUnlike = 1.5;          // ratio of two jumps of another size
  static constexpr std::int64_t kFewChanges = 4;  // from turn to turn

  // A repeat between two jumps, the smaller `beside`; onwards: both go the same way.
  void see_beat(bool onwards, double beside, double grid) noexcept {
    if (since_beat_ < kBunch * beat_ && beat_ >= kSlowBeat) return;
    const double times = std::max(1.0, std::round(since_beat_ / std::max(1.0, beat_)));
    const bool regular =
        beat_ >= kSlowBeat && times <= kMissedBeats && std::abs(since_beat_ - times * beat_) <= kRegular * beat_;
    if (!regular) regular_ = onwards_ = 0, beat_ = since_beat_, beside_ = beside;
    since_beat_ = 0.0;
    if (!regular) return;
    ++regular_;
    beside_ = std::min(beside_, beside);
    if (onwards) ++onwards_;
    // Readings that were rounded a second time keep the first rounding's step, which the smallest differences all show.
    const double rounding = smallest_[0] > kSameStep * step() ? std::max(grid, step()) : grid;
    const double by_chance = kDensity * beat_ * (regular_ + 1) * rounding / beside_;
    if (onwards_ > 0 && regular_ >= kBeats && by_chance < kNoChance) held_ = beats_ = true;
  }

  // The run ends in this jump.
  void see_run(double jump) noexcept {
    if (run_ < kLeastRun || run_ > shortest_ + 1 || run_ < longest_ - 1) {
      even_runs_ = reversals_ = 0;
      shortest_ = longest_ = run_;
    }
    if (run_ < kLeastRun) return;
    shortest_ = std::min(shortest_, run_);
    longest_ = std::max(longest_, run_);
    even_runs_ = std::min(even_runs_ + 1, kEvenRuns);
    const double a = std::abs(before_), b = std::abs(jump);
    if (before_ * jump < 0 && std::max(a, b) > kUnlike * std::min(a, b))
      reversals_ = std::min(reversals_ + 1, kReversals);
    if (even()) held_ = true;
  }
  [[nodiscard]] bool even() const noexcept { return even_runs_ == kEvenRuns && reversals_ == kReversals; }

  // The run of value_ ends in this jump to another number.
  void see_number(double reading, double jump) noexcept {
    if (jump * before_ < 0) ++turns_;
    if (value_ < high_ && value_ > low_) same_inside_ += run_ - 1;
    high_ = std::max(high_, value_);
    low_ = std::min(low_, value_);
    remembered_[next_remembered_++ % kRemembered] = value_;
    if (std::find(remembered_.begin(), remembered_.end(), reading) == remembered_.end()) return;
    ++recurring_;
    if (reading > low_ && reading < high_) ++recurring_inside_;
  }
  // More identical readings than chance brings to a motion of few numbers a period.
  [[nodiscard]] bool few_numbers() const noexcept {
    const std::int64_t changes = pairs_ - same_;
    return 10 * recurring_ < changes && changes <= kFewChanges * turns_ && pairs_ <= 2 * kFewChanges * turns_ &&
           3 * same_inside_ > pairs_ && beyond_chance(same_inside_, static_cast<double>(recurring_));
  }
  // Passed once in 10^7 where so many are expected (Poisson).
  [[nodiscard]] static bool beyond_chance(std::int64_t seen, double expected) noexcept {
    return static_cast<double>(seen) > 2 * expected + 6 * std::sqrt(expected) + 6;
  }

  void see(double size) noexcept {
    const double before = step();
    if (size < smallest_[0]) {
      smallest_ = {size, smallest_[0], smallest_[1]};
    } else if (size < smallest_[1]) {
      smallest_ = {smallest_[0], size, smallest_[1]};
    } else if (size < smallest_[2]) {
      smallest_[2] = size;
    }
    if (step() < before / 1.5) one_step_ = 2;  // the others were larger
    if (size < 1.5 * step()) ++one_step_;
  }
  void judge() noexcept {
    const double changes = static_cast<double>(pairs_ - same_);
    if (few_numbers()) held_ = true;
    if (changes < 3 || (interrupting_ == 0 && !held_)) return;
    const double expected = 0.5 * static_cast<double>(one_step_) + kDensity * changes * changes * step() / path_;
    if (beyond_chance(interrupting_, expected)) held_ = true;
    if (pairs_ >= kEnough && interrupting_ < kHardlyAny && !beats_ && !even() && !few_numbers()) held_ = false;
  }

  double value_ = NAN, before_ = 0.0, path_ = 0.0;
  std::int64_t run_ = 1, pairs_ = 0, same_ = 0, one_step_ = 0, interrupting_ = 0;
  std::array<double, 3> smallest_{INFINITY, INFINITY, INFINITY};
  double since_beat_ = 0.0, beat_ = 0.0;     // readings
  double beside_ = 0.0;                      // smallest jump beside the beats
  std::int64_t shortest_ = 0, longest_ = 0;  // of the latest runs whose lengths differ by one at most
  int even_runs_ = 0, reversals_ = 0;        // how many these are, and jumps among them that go back by another size
  int regular_ = 0, onwards_ = 0;            // beats in a row, and those of them amid a motion
  std::array<double, kRemembered> remembered_{};  // the newest numbers, each but the newest left again
  std::size_t next_remembered_ = 0;
  std::int64_t turns_ = 0, recurring_ = 0, recurring_inside_ = 0, same_inside_ = 0;  // inside: not at an extreme
  double low_ = INFINITY, high_ = -INFINITY;
  bool held_ = false, beats_ = false;
};

}  // namespace dwell
