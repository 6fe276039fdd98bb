// Finds out whether the device refreshes its register more slowly than it is read (a held register). Then runs of
// identical readings end in a jump.
//
// Only runs that interrupt a motion count: the jumps before and after go the same way, by more than two rounding steps
// each. At a turning point, with a sticking element or at a clipped crest the readings turn back after the run. A
// motion slower than the rounding goes on by one step. The k-th such run counts for k readings at most: a channel that
// was stuck for some seconds interrupts the motion once, a held register again and again.
//
// How many such readings does chance bring? The differences of a smooth motion with noise have a density near 0 that no
// rounding resolves: differences of 0 are as frequent as those of one step up, and of one step down. The step is the
// third smallest difference seen; a second rounding never makes it smaller than the device's own. So half of the
// differences within 1.5 steps are expected. Some densities rise towards 0, so kDensity of all changes times the step
// over the mean jump is added. (A sine has 0.20, Gaussian noise 0.32, a decaying sine up to 0.5.) beyond_chance()
// judges.
//
// A gateway that repeats its last answer at random interrupts the motion as well. repeat_pattern.hpp tells it from a
// register.
//
// Where few runs or none interrupt the motion, three others judge: a beat (repeat_beat.hpp), even runs (even_runs.hpp),
// and numbers that do not come back (recurring_numbers.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/intake/even_runs.hpp"
#include "core/intake/recurring_numbers.hpp"
#include "core/intake/repeat_beat.hpp"
#include "core/intake/repeat_pattern.hpp"
#include "core/intake/repeated_answers.hpp"
#include "core/intake/small_differences.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class HeldReadings {
 public:
  // The next reading; grid: its rounding step (0: none; INFINITY: not known). Returns whether it equals the one before.
  bool add(double reading, double grid) noexcept {
    const double jump = reading - value_;
    if (std::isnan(value_)) {
      value_ = reading;
      return false;
    }
    ++pairs_;
    beat_.next();
    pattern_.pass(1);
    if (jump == 0) {
      ++run_;
      ++same_;
      return true;
    }
    const double size = std::abs(jump), least = kJump * step();
    runs_.add(run_, before_, jump);
    numbers_.add(value_, run_, reading, jump * before_ < 0);
    answers_.add(run_, before_, jump, least, [this] { return mean_difference(); });
    path_ += size;
    differences_.add(size);
    if (run_ == 1 && repeated_ > 1) pattern_.caught(repeated_, before_repeated_, before_, jump, mean_difference());
    repeated_ = 0;
    if (run_ > 1 && std::abs(before_) > least && size > least) {
      const bool onwards = before_ * jump > 0;
      pattern_.repeat(run_, !many());
      repeated_ = run_;
      before_repeated_ = before_;
      if (onwards) interrupting_ += std::min(run_ - 1, ++interruptions_);
      // Readings rounded twice keep the coarser step of the first rounding: their smallest differences all equal it.
      const double rounding = differences_.least() > kSameStep * step() ? std::max(grid, step()) : grid;
      beat_.repeat(onwards, std::min(std::abs(before_), size), rounding, kDensity);
    }
    before_ = jump;
    value_ = reading;
    run_ = 1;
    judge();
    return false;
  }

  // The newest reading; NAN: there is none.
  [[nodiscard]] double newest() const noexcept { return value_; }
  // Whether add_plain() may be called: nothing shows a held register, and the newest reading came once.
  [[nodiscard]] bool plain() const noexcept {
    return !held_ && repeated_ == 0 && !suspected() && !beat_.found() && interrupting_ == 0 && run_ == 1 &&
           !numbers_.back() && numbers_.hardly_repeats(pairs_);
  }
  // The last sixteen numbers, the newest last.
  void copy_to(std::span<double, RecurringNumbers::kRemembered> numbers) const noexcept {
    numbers_.copy_to(numbers.first<RecurringNumbers::kRemembered - 1>());
    numbers.back() = value_;
  }
  // As add() for a reading that is other than the sixteen before, and by step() or more from the one before. Call
  // end_plain() after the last one of a run.
  void add_plain(double reading) noexcept {
    const double jump = reading - value_, size = std::abs(jump);
    ++pairs_;
    numbers_.pass(jump * before_ < 0);
    answers_.add(1, before_, jump, kJump * step(), [this] { return mean_difference(); });
    path_ += size;
    differences_.add(size);
    before_ = jump;
    value_ = reading;
  }
  // left: the reading before the run, and all of the run but the last; low, high: their range.
  void end_plain(std::span<const double> left, double low, double high) noexcept {
    runs_.add(1, 0.0, 0.0);
    numbers_.end_passing(left, low, high);
    beat_.pass(left.size());
    pattern_.pass(left.size());
  }

  // Number of identical readings up to the newest.
  [[nodiscard]] std::int64_t run() const noexcept { return run_; }
  // Mean difference of two consecutive readings; 0: not known.
  [[nodiscard]] double mean_difference() const noexcept {
    return pairs_ > 0 ? path_ / static_cast<double>(pairs_) : 0.0;
  }
  // The third smallest difference above 0, at least the rounding step; INFINITY: not known.
  [[nodiscard]] double step() const noexcept { return differences_.step(); }
  // A run has interrupted the motion, or repeats have come with a beat: refreshes are timed from now on.
  [[nodiscard]] bool suspected() const noexcept { return interrupting_ > 0 || beat_.suspected(); }
  // The register is refreshed more slowly than it is read.
  [[nodiscard]] bool held() const noexcept { return held_; }
  // Whether a reading that equals the one before tells nothing new: the register was not refreshed yet, or a gateway
  // repeated its answer. At most about a quarter of such readings are equal by chance.
  [[nodiscard]] bool repeats_tell_nothing() const noexcept {
    return held_ || (repeating_ && !(kFewByChance * by_chance() > static_cast<double>(same_) + kTooFewToTell));
  }
  // Mean number of readings per refresh. The refresh interval is this times the polling interval.
  [[nodiscard]] double reads_each() const noexcept {
    return static_cast<double>(pairs_) / std::max(1.0, static_cast<double>(changes()));
  }

  // The part of all readings that repeat, amid a motion, the reading before (one_before) or an older one (older). 0: no
  // more than chance and the repeats already left out explain. left_out: part of all readings left out as repeats.
  struct Again {
    double one_before = 0.0, older = 0.0;
  };
  [[nodiscard]] Again again(double left_out) const noexcept {
    Again again;
    if (changes() < 3) return again;
    const double all = static_cast<double>(pairs_), places = static_cast<double>(answers_.places());
    if (beyond_chance(answers_.repeats(), RepeatedAnswers::kSteepByChance * by_chance() + left_out * places))
      again.one_before = std::max(0.0, static_cast<double>(same_) - by_chance()) / all;
    if (beyond_chance(numbers_.returned(), RecurringNumbers::kRemembered * by_chance() + left_out * all))
      again.older = static_cast<double>(numbers_.returned()) / all;
    return again;
  }

  // A new hold of the drive: counts begin anew; the pattern and the beat go on. held() stands until the new counts
  // decide. But it is dropped at once if few readings repeated, and at random.
  void restart() noexcept {
    if (pattern_.random() && static_cast<double>(same_) <= kMostRandom * static_cast<double>(pairs_)) held_ = false;
    repeated_ = 0;
    pairs_ = same_ = interrupting_ = interruptions_ = 0;
    runs_.restart();
    numbers_.restart();
    answers_.restart();
    path_ = 0.0;
    differences_.restart();
  }

 private:
  static constexpr double kJump = 2.5, kDensity = 0.5, kSameStep = 0.9;
  // After kEnough pairs with fewer than kHardlyAny interrupting readings, held() is dropped.
  static constexpr std::int64_t kEnough = 4096, kHardlyAny = 8;
  // Largest part of the readings that a gateway may repeat at random, so that the times of its other answers are still
  // known. If more repeat, or if the pattern stays unclear, a register is assumed. Then an instant is known no better
  // than the two readings around it, which holds in either case.
  static constexpr double kMostRandom = 0.15;
  // Runs of repeats after which a register is assumed. kManyRuns: many() readings repeat. kPatience: fewer do, and the
  // pattern is unclear. kLongPatience: as kPatience, and the pattern may still become clear.
  static constexpr std::int64_t kManyRuns = 20, kPatience = 24, kLongPatience = 64;
  // Repeats tell nothing if chance explains at most 1 / kFewByChance of them, kTooFewToTell added to their number.
  static constexpr double kFewByChance = 4.0, kTooFewToTell = 16.0;

  [[nodiscard]] std::int64_t changes() const noexcept { return pairs_ - same_; }
  // Differences expected within half a step of 0, or of any other size that is small against the mean.
  [[nodiscard]] double by_chance() const noexcept {
    const auto differing = static_cast<double>(changes());
    return kDensity * differing * differing * step() / path_;
  }

  // Whether so many readings repeat the one before that no flaky gateway explains it.
  [[nodiscard]] bool many() const noexcept {
    const auto same = static_cast<double>(same_);
    return same > kMostRandom * static_cast<double>(pairs_) + 2 * std::sqrt(same);
  }
  void judge() noexcept {
    const bool otherwise = (beat_.found() && (pattern_.may_be_regular() || pattern_.regular())) || runs_.found() ||
                           numbers_.held_by_few(pairs_, changes());
    if (otherwise) held_ = true;
    if (changes() < 3 || (interrupting_ == 0 && !held_ && !repeating_)) return;
    if (beyond_chance(interrupting_, 0.5 * static_cast<double>(differences_.one_step()) + by_chance())) {
      repeating_ = true;
      if (refreshed()) held_ = true;
    }
    if (pairs_ >= kEnough && interrupting_ < kHardlyAny) {
      repeating_ = false;
      if (!otherwise) held_ = false;
    }
  }
  // Whether the repeats are those of a register. They are known to be more than chance brings.
  [[nodiscard]] bool refreshed() const noexcept {
    if (pattern_.regular()) return true;
    if (many()) return pattern_.may_be_regular() || interruptions_ >= kManyRuns;
    return interruptions_ >= (pattern_.may_be_random() ? kLongPatience : kPatience) && !pattern_.random();
  }

  double value_ = NAN, before_ = 0.0, path_ = 0.0;
  std::int64_t run_ = 1, same_ = 0, pairs_ = 0, interrupting_ = 0, interruptions_ = 0;
  SmallDifferences differences_;
  RepeatBeat beat_;
  RepeatPattern pattern_;
  std::int64_t repeated_ = 0;     // length of the run before the newest number, if it was a repeat; else 0
  double before_repeated_ = 0.0;  // the jump before that run
  EvenRuns runs_;
  RecurringNumbers numbers_;
  RepeatedAnswers answers_;
  bool held_ = false;
  bool repeating_ = false;  // more readings repeat the one before than chance brings
};

}  // namespace dwell
