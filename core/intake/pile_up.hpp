// Finds out whether a channel is clipped: then its readings pile up at an extreme (crest.hpp).
//
// Twice: over the hold, where weak evidence adds up, and over the newest stretch of it. A crest that is cut off from
// some instant on is lower than those before, and shows in the latter alone. A stretch is judged every 16 periods until
// it is long enough. At the w-th time -ln(w⁻² · 6/π²) more proof is asked for, so that all of them together bring a
// false alarm no oftener than one.
//
// Readings once cut off stay so until the restart, though later ones go beyond that end: a larger range makes what was
// read before no better.
//
// An end once found is remembered: readings that pile up there later need no proof against chance.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/intake/crest.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class PileUp {
 public:
  using Noise = Crest::Noise;
  // The next reading, the one before it, and functions that return the mean difference of consecutive readings and the
  // noise. The latter is called where the reading is beyond all others of the hold.
  template <class Difference, class NoiseNow>
  void add(double reading, double before, Difference&& difference, NoiseNow&& noise) noexcept {
    for (End* end : {&upper_, &lower_}) {
      const double sign = end == &upper_ ? 1.0 : -1.0;
      if (sign * reading > end->of_hold.top())
        end->pass(end->now(noise(), stuck_elsewhere()), end->of_hold.top(), seen_);
      end->of_hold.add(sign * reading, sign * before, difference);
      end->of_stretch.add(sign * reading, sign * before, difference);
    }
    ++seen_;
    ++seen_lately_;
  }
  // The newest reading makes a run of identical ones longer than a crest explains. Called once per run.
  void stuck() noexcept {
    ++stuck_;
    upper_.of_hold.stuck();
    lower_.of_hold.stuck();
  }
  // A period of the drive is over.
  void next_period(const Noise& noise) noexcept {
    if (++periods_ % kPeriods != 0) return;
    const double w = static_cast<double>(periods_ / kPeriods);
    const double more = std::log(w * w * std::numbers::pi * std::numbers::pi / 6);
    bool found = false;
    for (End* end : {&upper_, &lower_}) {
      // Where the hold's own end is reached, the hold's count has these readings.
      const double top = end->of_stretch.top();
      const std::int64_t cut_off =
          top < end->of_hold.top() ? end->of_stretch.cut_off(noise, 0, end->proof_of_stretch(more)) : 0;
      end->pass(cut_off, top, seen_lately_);
      found |= cut_off > 0;
    }
    if (!found && seen_lately_ < kStretch) return;
    upper_.of_stretch = lower_.of_stretch = {};
    seen_lately_ = 0;
  }

  // How many readings since the restart are cut off at the upper and at the lower end; 0: none.
  [[nodiscard]] std::int64_t above(const Noise& noise) const noexcept {
    return upper_.passed + upper_.now(noise, stuck_elsewhere());
  }
  [[nodiscard]] std::int64_t below(const Noise& noise) const noexcept {
    return lower_.passed + lower_.now(noise, stuck_elsewhere());
  }
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  // Loss of the fundamental's amplitude, relative; 0: none. If the part p of all readings is cut off at one end, the
  // fundamental loses (2/3π)(πp)³: the first term of the series of a clipped sine. Stretches that were cut off
  // differently have their parts in the mean.
  [[nodiscard]] double loss(const Noise& noise) const noexcept {
    double lost = 0.0;
    for (const End* end : {&upper_, &lower_}) lost += end->lost + lost_of(end->now(noise, stuck_elsewhere()), seen_);
    return seen_ > 0 ? lost / static_cast<double>(seen_) : 0.0;
  }
  // Where readings are cut off, in the device's numbers; where none is, the largest and the smallest.
  [[nodiscard]] double upper_end() const noexcept { return upper_.at(); }
  [[nodiscard]] double lower_end() const noexcept { return -lower_.at(); }
  // A new hold: counts begin anew, ends found so far are remembered.
  void restart(const Noise& noise) noexcept {
    const bool found[] = {above(noise) > 0, below(noise) > 0};
    for (End* end : {&upper_, &lower_}) {
      End next;
      next.known = found[end == &upper_ ? 0 : 1] ? end->at() : end->known;
      *end = next;
    }
    seen_ = seen_lately_ = stuck_ = periods_ = 0;
  }

 private:
  // A crest cut off at 0.8 shows within so many periods of ten readings: a fifth of them is at each end.
  static constexpr std::int64_t kPeriods = 16;
  // With so many readings one cut off at 0.95 shows where rounding of 10⁻³ hides the noise: 1000 are at each end, 24 at
  // the commonest number below, and 1024 (x ln(x/p) + (1-x) ln((1-x)/(1-p))) = 39 with p = 10/11. After a day at 4 Hz
  // 34 is asked for.
  static constexpr std::int64_t kStretch = 10'000;
  static constexpr double kAtFoundEnd = 6.9;  // -ln 10⁻³
  struct End {
    Crest of_hold, of_stretch;
    double known = INFINITY;  // the end of the transducer's range, found before
    std::int64_t passed = 0;  // readings cut off below the hold's largest
    double passed_at = 0.0;   // the newest end at which they were
    double lost = 0.0;        // by them: relative loss of the fundamental times readings

    // Readings that are cut off at the hold's largest.
    [[nodiscard]] std::int64_t now(const Noise& noise, std::int64_t elsewhere) const noexcept {
      return of_hold.cut_off(noise, elsewhere, of_hold.top() == known ? Crest::kNone : Crest::kProof);
    }
    // A few readings at an end found before may be chance: less proof is asked for there, but some.
    [[nodiscard]] Crest::Proof proof_of_stretch(double more) const noexcept {
      const double top = of_stretch.top();
      const bool found = top == known || (passed > 0 && top == passed_at);
      return {(found ? kAtFoundEnd : Crest::kProof.unlikely) + more, Crest::kProof.unlikely_runs + more};
    }
    // `readings` of `seen` were cut off at an end that others went beyond.
    void pass(std::int64_t readings, double at, std::int64_t seen) noexcept {
      if (readings == 0) return;
      passed += readings;
      passed_at = at;
      lost += lost_of(readings, seen);
    }
    [[nodiscard]] double at() const noexcept { return passed > 0 ? passed_at : of_hold.top(); }
  };
  [[nodiscard]] static double lost_of(std::int64_t cut_off, std::int64_t seen) noexcept {
    if (cut_off == 0) return 0.0;
    const auto all = static_cast<double>(seen);
    return all * 2 / (3 * std::numbers::pi) * std::pow(std::numbers::pi * static_cast<double>(cut_off) / all, 3);
  }
  [[nodiscard]] std::int64_t stuck_elsewhere() const noexcept {
    return stuck_ - upper_.of_hold.runs_at_top() - lower_.of_hold.runs_at_top();
  }

  End upper_, lower_;
  std::int64_t seen_ = 0, seen_lately_ = 0;  // readings: of the hold, of the stretch
  std::int64_t stuck_ = 0, periods_ = 0;     // of the hold
};

}  // namespace dwell
