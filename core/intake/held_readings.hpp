// Finds out whether the device refreshes its register more slowly than it is read (a held register). Then runs of
// identical readings end in a jump.
//
// Only runs that interrupt a motion count: the jumps before and after go the same way, by more than two rounding steps
// each. At a turning point, with a sticking element or at a clipped crest the readings turn back after the run. A
// motion slower than the rounding goes on by one step. repeat_counts.hpp says how many such readings chance brings.
//
// A gateway that repeats its last answer at random interrupts the motion as well. repeat_pattern.hpp tells it from a
// register.
//
// Where few runs or none interrupt the motion, three others judge: a beat (repeat_beat.hpp), even runs (even_runs.hpp),
// and numbers that do not come back (recurring_numbers.hpp).
//
// What the repeats are taken for:
//
//   chance   ── more than chance brings ──>          answers   a gateway may repeat its answers
//   chance, answers ── a register's pattern ──>      held      the register is refreshed more slowly than it is read
//   held     ── new hold, few repeats, random ──>    answers
//   answers, held ── hardly any after 4096 pairs ──> chance
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/intake/even_runs.hpp"
#include "core/intake/recurring_numbers.hpp"
#include "core/intake/repeat_beat.hpp"
#include "core/intake/repeat_counts.hpp"
#include "core/intake/repeat_pattern.hpp"
#include "core/intake/repeated_answers.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class HeldReadings {
 public:
  // The next reading; grid: its rounding step (0: none; INFINITY: not known). Returns whether it equals the one before.
  bool add(double reading, double grid) noexcept {
    if (std::isnan(newest_.number)) {
      newest_.number = reading;
      return false;
    }
    const double jump = reading - newest_.number;
    counts_.next();
    beat_.next();
    pattern_.pass(1);
    if (jump == 0) {
      ++newest_.run;
      counts_.repeats_one_before();
      return true;
    }
    end_run(jump, grid, reading);
    newest_ = {reading, jump, 1};
    judge();
    return false;
  }

  // The newest reading; NAN: there is none.
  [[nodiscard]] double newest() const noexcept { return newest_.number; }
  // Whether add_plain() may be called: nothing shows a held register, and the newest reading came once.
  [[nodiscard]] bool plain() const noexcept {
    return !held() && ended_.run == 0 && !suspected() && !beat_.found() && newest_.run == 1 && !numbers_.back() &&
           numbers_.hardly_repeats(counts_.pairs());
  }
  // The last sixteen numbers, the newest last.
  void copy_to(std::span<double, RecurringNumbers::kRemembered> numbers) const noexcept {
    numbers_.copy_to(numbers.first<RecurringNumbers::kRemembered - 1>());
    numbers.back() = newest_.number;
  }
  // As add() for a reading that is other than the sixteen before, and by step() or more from the one before. Call
  // end_plain() after the last one of a run.
  void add_plain(double reading) noexcept {
    const double jump = reading - newest_.number;
    counts_.next();
    numbers_.pass(jump * newest_.jump < 0);
    answers_.add(1, newest_.jump, jump, kJump * step(), [this] { return mean_difference(); });
    counts_.differs(std::abs(jump));
    newest_.jump = jump;
    newest_.number = reading;
  }
  // left: the reading before the run, and all of the run but the last; low, high: their range.
  void end_plain(std::span<const double> left, double low, double high) noexcept {
    runs_.add(1, 0.0, 0.0);
    numbers_.end_passing(left, low, high);
    beat_.pass(left.size());
    pattern_.pass(left.size());
  }

  // Number of identical readings up to the newest.
  [[nodiscard]] std::int64_t run() const noexcept { return newest_.run; }
  // Mean difference of two consecutive readings; 0: not known.
  [[nodiscard]] double mean_difference() const noexcept { return counts_.mean_difference(); }
  // The third smallest difference above 0, at least the rounding step; INFINITY: not known.
  [[nodiscard]] double step() const noexcept { return counts_.step(); }
  // A run has interrupted the motion, or repeats have come with a beat: refreshes are timed from now on.
  [[nodiscard]] bool suspected() const noexcept { return counts_.interrupts() || beat_.suspected(); }
  // The register is refreshed more slowly than it is read.
  [[nodiscard]] bool held() const noexcept { return taken_for_ == TakenFor::held; }
  // Whether a reading that equals the one before tells nothing new: the register was not refreshed yet, or a gateway
  // repeated its answer. At most about a quarter of such readings are equal by chance.
  [[nodiscard]] bool repeats_tell_nothing() const noexcept {
    return held() || (taken_for_ == TakenFor::answers && !counts_.mostly_by_chance());
  }
  // Mean number of readings per refresh. The refresh interval is this times the polling interval.
  [[nodiscard]] double reads_each() const noexcept {
    return static_cast<double>(counts_.pairs()) / std::max(1.0, static_cast<double>(counts_.changes()));
  }

  // The part of all readings that repeat, amid a motion, the reading before (one_before) or an older one (older). 0: no
  // more than chance and the repeats already left out explain. left_out: part of all readings left out as repeats.
  struct Again {
    double one_before = 0.0, older = 0.0;
  };
  [[nodiscard]] Again again(double left_out) const noexcept {
    Again again;
    if (!counts_.step_known()) return again;
    const double all = static_cast<double>(counts_.pairs()), places = static_cast<double>(answers_.places()),
                 by_chance = counts_.by_chance();
    if (beyond_chance(answers_.repeats(), RepeatedAnswers::kSteepByChance * by_chance + left_out * places))
      again.one_before = std::max(0.0, static_cast<double>(counts_.repeats()) - by_chance) / all;
    if (beyond_chance(numbers_.returned(), RecurringNumbers::kRemembered * by_chance + left_out * all))
      again.older = static_cast<double>(numbers_.returned()) / all;
    return again;
  }

  // A new hold of the drive: counts begin anew; the pattern and the beat go on. held() stands until the new counts
  // decide. But it is dropped at once if few readings repeated, and at random.
  void restart() noexcept {
    if (held() && pattern_.random() && counts_.few()) taken_for_ = TakenFor::answers;
    ended_ = {};
    counts_.restart();
    runs_.restart();
    numbers_.restart();
    answers_.restart();
  }

 private:
  enum class TakenFor : std::uint8_t { chance, answers, held };
  // Identical readings, and the jump before them.
  struct Run {
    double number = NAN, jump = 0.0;
    std::int64_t run = 1;
  };
  // The repeat that ended with the newest jump.
  struct EndedRepeat {
    std::int64_t run = 0;  // its length; 0: none
    double jump = 0.0;     // the one before it
  };

  static constexpr double kJump = 2.5, kSameStep = 0.9;  // steps
  // Runs of repeats after which a register is assumed. kManyRuns: many readings repeat. kPatience: fewer do, and the
  // pattern is unclear. kLongPatience: as kPatience, and the pattern may still become clear.
  static constexpr std::int64_t kManyRuns = 20, kPatience = 24, kLongPatience = 64;

  // The newest run has ended with a jump to `reading`.
  void end_run(double jump, double grid, double reading) noexcept {
    const auto [number, before, run] = newest_;
    const double size = std::abs(jump), least = kJump * step();
    runs_.add(run, before, jump);
    numbers_.add(number, run, reading, jump * before < 0);
    answers_.add(run, before, jump, least, [this] { return mean_difference(); });
    counts_.differs(size);
    if (run == 1 && ended_.run > 1) pattern_.caught(ended_.run, ended_.jump, before, jump, mean_difference());
    ended_ = {};
    if (run == 1 || !(std::abs(before) > least) || !(size > least)) return;
    const bool onwards = before * jump > 0;
    pattern_.repeat(run, !counts_.many());
    ended_ = {run, before};
    if (onwards) counts_.interrupted(run);
    // Readings rounded twice keep the coarser step of the first rounding: their smallest differences all equal it.
    const double rounding = counts_.least_difference() > kSameStep * step() ? std::max(grid, step()) : grid;
    beat_.repeat(onwards, std::min(std::abs(before), size), rounding, RepeatCounts::kDensity);
  }

  void judge() noexcept {
    const bool otherwise = (beat_.found() && (pattern_.may_be_regular() || pattern_.regular())) || runs_.found() ||
                           numbers_.held_by_few(counts_.pairs(), counts_.changes());
    if (otherwise) taken_for_ = TakenFor::held;
    if (!counts_.step_known() || (taken_for_ == TakenFor::chance && !counts_.interrupts())) return;
    if (!held() && counts_.interrupts_beyond_chance()) taken_for_ = refreshed() ? TakenFor::held : TakenFor::answers;
    if (!otherwise && counts_.hardly_interrupts()) taken_for_ = TakenFor::chance;
  }
  // Whether the repeats are those of a register. They are known to be more than chance brings.
  [[nodiscard]] bool refreshed() const noexcept {
    if (pattern_.regular()) return true;
    if (counts_.many()) return pattern_.may_be_regular() || counts_.interruptions() >= kManyRuns;
    return counts_.interruptions() >= (pattern_.may_be_random() ? kLongPatience : kPatience) && !pattern_.random();
  }

  Run newest_;
  EndedRepeat ended_;
  RepeatCounts counts_;
  RepeatBeat beat_;
  RepeatPattern pattern_;
  EvenRuns runs_;
  RecurringNumbers numbers_;
  RepeatedAnswers answers_;
  TakenFor taken_for_ = TakenFor::chance;
};

}  // namespace dwell
