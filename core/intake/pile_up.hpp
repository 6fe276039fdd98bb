// Finds out whether a channel is clipped: then its readings pile up at an extreme (crest.hpp).
//
// A channel is judged over the whole hold, where weak evidence adds up, and over its newest stretches. If clipping
// begins amid a hold, the crests before are higher, so only a stretch that holds none of them shows it. A long stretch
// is judged every 16 periods and ends with a finding, or at 10 000 readings. With few readings a period that takes many
// periods. Then there are also short stretches of 8, 16, 32 … periods, each judged at its end and begun anew. So
// clipping that N periods of readings prove is found within 4 N periods after it began, and within 16 where 8 suffice.
// They are judged once the transient is over: before, what a fit leaves of it passes for noise. With many readings a
// period they would cost more than all else that is done with a reading.
//
// The w-th judgement of the long stretch needs ln(2 w² π²/6) more proof, that of the l-th short length ln(2 2^l w²
// π²/6): all of them together have the false-alarm rate of one.
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
      }
      for (std::size_t l = 0; l < lengths_; ++l) {
        stretches_[l].upper.add(reading, before, difference);
        stretches_[l].lower.add(-reading, -before, difference);
      }
      long_.upper.add(reading, before, difference);
      long_.lower.add(-reading, -before, difference);
      find_amid();
    }
    ++seen_;
  }
  // A reading between these changes no crest.
  [[nodiscard]] double amid_above() const noexcept { return low_; }
  [[nodiscard]] double amid_below() const noexcept { return high_; }
  // So many readings between these, one at least.
  void add_amid(std::size_t readings) noexcept {
    amid_ = true;
    seen_ += static_cast<std::int64_t>(readings);
  }
  // The newest reading makes a run of identical ones longer than a crest explains. Called once per run, after its
  // add().
  void stuck() noexcept {
    ++stuck_;
    if (amid_) return;
    for (End* end : {&upper_, &lower_}) end->of_hold.stuck();
    for (Stretch& stretch : stretches_) stretch.stuck();
    long_.stuck();
  }
  // A period of the drive is over.
  void next_period(const Noise& noise) noexcept {
    if (++periods_ % kPeriods != 0) return;
    bool found = false;
    for (std::size_t l = 0; l < lengths_ && !found && periods_ % (kPeriods << l) == 0; ++l) {
      Stretch& stretch = stretches_[l];
      found = judge(stretch, judged_[l], static_cast<double>(l + 2), noise);
      if (found) break;
      const std::int64_t readings = seen_ - stretch.seen_before;
      if (l == 0 && readings > kPeriods * kFewReadings) {
        lengths_ = 0;
      } else if (readings >= kStretch / 2) {
        lengths_ = l + 1;  // longer ones tell no more than the long stretch
      }
      stretch = {{}, {}, seen_, stuck_};
    }
    if (!found && periods_ % kLongPeriods == 0) {
      found = judge(long_, judged_long_, 1.0, noise);
      if (!found && seen_ - long_.seen_before >= kStretch) long_ = {{}, {}, seen_, stuck_};
    }
    if (found) begin_stretches();
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
  // The transient is over: its residuals are no longer taken for noise. Short stretches are judged from now on.
  void begin_to_count() noexcept {
    lengths_ = kLengths;
    begin_stretches();
    find_amid();
  }
  // A new hold: counts begin anew, ends found so far are remembered.
  void restart(const Noise& noise) noexcept {
    const std::int64_t upper = now(upper_, noise), lower = now(lower_, noise);
    upper_ = upper_.of_next_hold(upper);
    lower_ = lower_.of_next_hold(lower);
    seen_ = stuck_ = 0;
    judged_ = {};
    judged_long_ = 0;
    lengths_ = 0;
    begin_stretches();
    find_amid();
  }

 private:
  // Periods of the shortest stretch. A crest cut off at 0.9 shows within so many of five readings: a seventh of them is
  // at each end. Twice as many: clipping is found twice as late.
  static constexpr std::int64_t kPeriods = 8;
  // A crest cut off at 0.8 shows within so many periods of ten readings: a fifth of them is at each end.
  static constexpr std::int64_t kLongPeriods = 2 * kPeriods;
  // Most readings a period with which there are short stretches: the long one then takes 39 s at 4 Hz, or more. Of 100
  // readings a period a third would lie near the crest of a short stretch, and be judged one by one.
  static constexpr std::int64_t kFewReadings = 64;
  // With so many readings one cut off at 0.95 shows where rounding of 10⁻³ hides the noise: 1000 are at each end, 24 at
  // the commonest number below, and 1024 (x ln(x/p) + (1-x) ln((1-x)/(1-p))) = 39 with p = 10/11. After a day at 4 Hz
  // 36 is asked for.
  static constexpr std::int64_t kStretch = 10'000;
  // Of this many readings one at the end, at least, where the step is assumed. Cut off at 0.99 there is one of 22.
  static constexpr std::int64_t kEnough = 25;
  // Lengths of short stretches: of three readings a period the longest has 6144.
  static constexpr std::size_t kLengths = 9;
  // -ln 10⁻³: the end is known, so only chance within this stretch is to be excluded. Smaller: two readings at an old
  // end withhold a sound hold. Larger: an end that comes back shows later.
  static constexpr double kAtFoundEnd = 6.9;
  // Steps of rounding between the lowest and the highest reading of a motion. An end cut off by less than five steps is
  // not found anyway.
  static constexpr double kMoves = 10.0;
  struct Stretch {
    Crest upper, lower;
    std::int64_t seen_before = 0, stuck_before = 0;  // of the hold, before the stretch: readings, long runs

    void stuck() noexcept {
      upper.stuck();
      lower.stuck();
    }
  };
  struct End {
    Crest of_hold;
    double known = INFINITY;  // the end of the transducer's range, found before
    std::int64_t passed = 0;  // readings cut off below the hold's largest
    double passed_at = 0.0;   // the newest end at which they were
    double lost = 0.0;        // by them: relative loss of the fundamental times readings

    // Readings that are cut off at the hold's largest.
    [[nodiscard]] std::int64_t now(const Noise& noise, std::int64_t elsewhere) const noexcept {
      return of_hold.cut_off(noise, elsewhere, of_hold.top() == known ? Crest::kNone : Crest::kProof);
    }
    // A few readings at an end found before may be chance: less proof is asked for there, but some.
    [[nodiscard]] Crest::Proof proof_of_stretch(double top, double more) const noexcept {
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
  // Whether a stretch is cut off at an end. judged: how often stretches of its length were judged. share: 2^-share of
  // the probability of a false alarm is theirs.
  bool judge(const Stretch& stretch, std::int64_t& judged, double share, const Noise& noise) noexcept {
    const auto w = static_cast<double>(++judged);
    const double more = share * std::numbers::ln2 + std::log(w * w * std::numbers::pi * std::numbers::pi / 6);
    const std::int64_t elsewhere =
        stuck_ - stretch.stuck_before - stretch.upper.runs_at_top() - stretch.lower.runs_at_top();
    bool found = false;
    for (End* end : {&upper_, &lower_}) {
      const Crest& crest = end == &upper_ ? stretch.upper : stretch.lower;
      const double top = crest.top();
      // Where the hold's own end is reached, the hold's count has these readings.
      const std::int64_t seen = seen_ - stretch.seen_before;
      const std::int64_t cut_off =
          top < end->of_hold.top() && moves(noise)
              ? enough(crest.cut_off(noise, elsewhere, end->proof_of_stretch(top, more)), seen, noise)
              : 0;
      end->pass(cut_off, top, seen);
      found |= cut_off > 0;
    }
    return found;
  }
  void begin_stretches() noexcept {
    periods_ = 0;
    for (Stretch& stretch : stretches_) stretch = {{}, {}, seen_, stuck_};
    long_ = stretches_[0];
  }
  // Computes low_ and high_ anew: after each change of a crest. A reading between them changes no crest. Most readings
  // are such, and cost two comparisons only.
  void find_amid() noexcept {
    high_ = std::min(upper_.of_hold.least(), long_.upper.least());
    low_ = std::min(lower_.of_hold.least(), long_.lower.least());
    for (std::size_t l = 0; l < lengths_; ++l) {
      high_ = std::min(high_, stretches_[l].upper.least());
      low_ = std::min(low_, stretches_[l].lower.least());
    }
    low_ = -low_;
  }
  // So many readings that seem cut off, if they are enough to believe it. What a transient leaves passes for noise, and
  // a few readings near a whole fraction of the period then for a crest cut off.
  [[nodiscard]] static std::int64_t enough(std::int64_t cut_off, std::int64_t seen, const Noise& noise) noexcept {
    return noise.assumed && kEnough * cut_off < seen ? 0 : cut_off;
  }
  [[nodiscard]] bool moves(const Noise& noise) const noexcept {
    return upper_.of_hold.top() + lower_.of_hold.top() >= kMoves * noise.step;
  }
  [[nodiscard]] std::int64_t now(const End& end, const Noise& noise) const noexcept {
    return moves(noise) ? enough(end.now(noise, stuck_elsewhere()), seen_, noise) : 0;
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
  double low_ = INFINITY, high_ = -INFINITY;  // see find_amid()
  bool amid_ = false;                         // the newest reading lies between these
  std::int64_t seen_ = 0, stuck_ = 0;         // of the hold: readings, long runs
  std::int64_t periods_ = 0;                  // since the stretches began together
  std::array<Stretch, kLengths> stretches_;   // short ones: of kPeriods, and each twice as long as the one before
  Stretch long_;
  std::size_t lengths_ = 0;  // number of short stretches that are judged
  std::array<std::int64_t, kLengths> judged_{};
  std::int64_t judged_long_ = 0;
};

}  // namespace dwell
