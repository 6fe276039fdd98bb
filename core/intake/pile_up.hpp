// Finds out whether a channel is clipped: then its readings pile up at an extreme (crest.hpp).
//
// A channel is judged twice: over the whole hold, where weak evidence adds up, and over its newest stretch. If clipping
// begins amid a hold, the crests before are higher, so only the stretch shows it. A stretch is judged every 16 periods
// and ends with a finding, or at 10 000 readings. The w-th judgement needs ln(w² π²/6) more proof: all of them together
// have the false-alarm rate of one.
//
// Readings once cut off count as cut off until the restart. A larger range afterwards does not repair them.
//
// An end once found is remembered. Later, over a hold, readings that pile up there need no proof against chance; over a
// stretch they need less.
//
// A channel at rest flickers between two or three numbers. It has no crest, so nothing is judged.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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
    amid_ = reading > low_ && reading < high_;
    if (!amid_) {
      for (End* end : {&upper_, &lower_}) {
        const double sign = end == &upper_ ? 1.0 : -1.0;
        if (sign * reading > end->of_hold.top()) end->pass(now(*end, noise()), end->of_hold.top(), seen_);
        end->of_hold.add(sign * reading, sign * before, difference);
        end->of_stretch.add(sign * reading, sign * before, difference);
      }
      find_amid();
    }
    ++seen_;
    ++seen_lately_;
  }
  // A reading between these changes no crest.
  [[nodiscard]] double amid_above() const noexcept { return low_; }
  [[nodiscard]] double amid_below() const noexcept { return high_; }
  // So many readings between these, one at least.
  void add_amid(std::size_t readings) noexcept {
    amid_ = true;
    seen_ += static_cast<std::int64_t>(readings);
    seen_lately_ += static_cast<std::int64_t>(readings);
  }
  // The newest reading makes a run of identical ones longer than a crest explains. Called once per run, after its
  // add().
  void stuck() noexcept {
    ++stuck_;
    ++stuck_lately_;
    if (amid_) return;
    for (End* end : {&upper_, &lower_}) {
      end->of_hold.stuck();
      end->of_stretch.stuck();
    }
  }
  // A period of the drive is over.
  void next_period(const Noise& noise) noexcept {
    if (++periods_ % kPeriods != 0) return;
    const double w = static_cast<double>(periods_ / kPeriods);
    const double more = std::log(w * w * std::numbers::pi * std::numbers::pi / 6);
    const std::int64_t elsewhere = stuck_lately_ - upper_.of_stretch.runs_at_top() - lower_.of_stretch.runs_at_top();
    bool found = false;
    for (End* end : {&upper_, &lower_}) {
      // Where the hold's own end is reached, the hold's count has these readings.
      const double top = end->of_stretch.top();
      const std::int64_t cut_off = top < end->of_hold.top() && moves(noise)
                                       ? end->of_stretch.cut_off(noise, elsewhere, end->proof_of_stretch(more))
                                       : 0;
      end->pass(cut_off, top, seen_lately_);
      found |= cut_off > 0;
    }
    if (!found && seen_lately_ < kStretch) return;
    upper_.of_stretch = lower_.of_stretch = {};
    seen_lately_ = stuck_lately_ = 0;
    find_amid();
  }

  // How many readings since the restart are cut off at the upper and at the lower end; 0: none.
  [[nodiscard]] std::int64_t above(const Noise& noise) const noexcept { return upper_.passed + now(upper_, noise); }
  [[nodiscard]] std::int64_t below(const Noise& noise) const noexcept { return lower_.passed + now(lower_, noise); }
  [[nodiscard]] std::int64_t seen() const noexcept { return seen_; }
  // Loss of the fundamental's amplitude, relative; 0: none. If the part p of all readings is cut off at one end, a sine
  // loses (θ - sin θ cos θ)/π, θ = πp. Stretches that were cut off differently have their parts in the mean.
  [[nodiscard]] double loss(const Noise& noise) const noexcept {
    double lost = 0.0;
    for (const End* end : {&upper_, &lower_}) lost += end->lost + lost_of(now(*end, noise), seen_);
    return seen_ > 0 ? lost / static_cast<double>(seen_) : 0.0;
  }
  // Largest relative loss of the fundamental's amplitude by clipping at both ends that rounding in steps of `step`
  // hides. 0: the amplitude is not known.
  [[nodiscard]] double unseen_loss(double step) const noexcept {
    const double amplitude = (upper_.of_hold.top() + lower_.of_hold.top()) / 2;
    if (!(amplitude > 0) || !std::isfinite(amplitude)) return 0.0;
    const double theta = std::acos(std::max(0.0, 1 - Crest::kUnseenSteps * step / amplitude));
    return 2 * (theta - std::sin(theta) * std::cos(theta)) / std::numbers::pi;
  }
  // The newest end at which readings were cut off, in the device's numbers; where none was, the largest and the
  // smallest.
  [[nodiscard]] double upper_end(const Noise& noise) const noexcept { return upper_.at(now(upper_, noise)); }
  [[nodiscard]] double lower_end(const Noise& noise) const noexcept { return -lower_.at(now(lower_, noise)); }
  // A new hold: counts begin anew, ends found so far are remembered.
  void restart(const Noise& noise) noexcept {
    const std::int64_t upper = now(upper_, noise), lower = now(lower_, noise);
    upper_ = upper_.of_next_hold(upper);
    lower_ = lower_.of_next_hold(lower);
    seen_ = seen_lately_ = stuck_ = stuck_lately_ = periods_ = 0;
    find_amid();
  }

 private:
  // A crest cut off at 0.8 shows within so many periods of ten readings: a fifth of them is at each end.
  static constexpr std::int64_t kPeriods = 16;
  // With so many readings one cut off at 0.95 shows where rounding of 10⁻³ hides the noise: 1000 are at each end, 24 at
  // the commonest number below, and 1024 (x ln(x/p) + (1-x) ln((1-x)/(1-p))) = 39 with p = 10/11. After a day at 4 Hz
  // 34 is asked for.
  static constexpr std::int64_t kStretch = 10'000;
  // -ln 10⁻³: the end is known, so only chance within this stretch is to be excluded. Smaller: two readings at an old
  // end withhold a sound hold. Larger: an end that comes back shows later.
  static constexpr double kAtFoundEnd = 6.9;
  // Steps of rounding between the lowest and the highest reading of a motion. An end cut off by less than five steps is
  // not found anyway.
  static constexpr double kMoves = 10.0;
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
    // The newest end at which readings were cut off, `now_cut_off` of them at the hold's largest.
    [[nodiscard]] double at(std::int64_t now_cut_off) const noexcept {
      return passed > 0 && now_cut_off == 0 ? passed_at : of_hold.top();
    }
    [[nodiscard]] End of_next_hold(std::int64_t now_cut_off) const noexcept {
      End next;
      next.known = passed + now_cut_off > 0 ? at(now_cut_off) : known;
      return next;
    }
  };
  // Computes low_ and high_ anew: after each change of a crest. A reading between them changes no crest. Most readings
  // are such, and cost two comparisons only.
  void find_amid() noexcept {
    high_ = std::min(upper_.of_hold.least(), upper_.of_stretch.least());
    low_ = -std::min(lower_.of_hold.least(), lower_.of_stretch.least());
  }
  [[nodiscard]] bool moves(const Noise& noise) const noexcept {
    return upper_.of_hold.top() + lower_.of_hold.top() >= kMoves * noise.step;
  }
  [[nodiscard]] std::int64_t now(const End& end, const Noise& noise) const noexcept {
    return moves(noise) ? end.now(noise, stuck_elsewhere()) : 0;
  }
  [[nodiscard]] static double lost_of(std::int64_t cut_off, std::int64_t seen) noexcept {
    if (cut_off == 0) return 0.0;
    const auto all = static_cast<double>(seen);
    const double theta = std::numbers::pi * static_cast<double>(cut_off) / all;
    return all * (theta - std::sin(theta) * std::cos(theta)) / std::numbers::pi;
  }
  [[nodiscard]] std::int64_t stuck_elsewhere() const noexcept {
    return stuck_ - upper_.of_hold.runs_at_top() - lower_.of_hold.runs_at_top();
  }

  End upper_, lower_;
  double low_ = INFINITY, high_ = -INFINITY;   // see find_amid()
  bool amid_ = false;                          // the newest reading lies between these
  std::int64_t seen_ = 0, seen_lately_ = 0;    // readings: of the hold, of the stretch
  std::int64_t stuck_ = 0, stuck_lately_ = 0;  // long runs: of the hold, of the stretch
  std::int64_t periods_ = 0;                   // of the hold
};

}  // namespace dwell
