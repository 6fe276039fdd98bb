// Finds out whether a channel is clipped: then its readings pile up at an extreme (crest.hpp).
//
// A channel is judged over the whole hold, where weak evidence adds up, and over its newest stretches. If clipping
// begins amid a hold, the crests before are higher, so only a stretch that began later shows it. Stretches of 48, 192,
// 768 and 3072 periods run beside each other; each length repeats without gaps. If N periods of clipping are proof
// enough, a stretch of at least N periods begins within 48 or 4 N periods (N up to 3072).
//
// All stretches are judged every 16 periods. Judgement w asks for ln(w² π²/6) more proof, and k stretches for ln k
// more: so all of them together have the false-alarm rate of one. After a finding at either end all begin anew.
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
        if (sign * reading > end->of_hold.top()) end->pass({now(*end, noise()), end->of_hold.top(), seen_});
        end->of_hold.add(sign * reading, sign * before, difference);
        for (Crest& crest : end->of_stretches) crest.add(sign * reading, sign * before, difference);
      }
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
    for (End* end : {&upper_, &lower_}) {
      end->of_hold.stuck();
      for (Crest& crest : end->of_stretches) crest.stuck();
    }
  }
  // A period of the drive is over.
  void next_period(const Noise& noise) noexcept {
    if (++periods_ % kPeriods != 0) return;
    const std::int64_t judgement = periods_ / kPeriods;
    const auto w = static_cast<double>(judgement);
    const double more =
        std::log(w * w * std::numbers::pi * std::numbers::pi / 6 * static_cast<double>(kStretchLengths));
    bool found = false;
    for (End* end : {&upper_, &lower_}) found |= end->pass(most_cut_off(*end, noise, more));
    for (std::size_t s = 0; s < kStretchLengths; ++s)
      if (found || judgement % judgements_of(s) == 0) begin_stretch(s);
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
    seen_ = stuck_ = periods_ = 0;
    begun_ = {};
    find_amid();
  }

 private:
  // A crest cut off at 0.8 shows within so many periods of ten readings: a fifth of them is at each end.
  static constexpr std::int64_t kPeriods = 16;
  // In a stretch of 10 000 readings, 3072 periods of three, a crest cut off at 0.95 shows where rounding of 10⁻³ hides
  // the noise: 1000 are at each end, 24 at the commonest number below, and 1024 (x ln(x/p) + (1-x) ln((1-x)/(1-p))) =
  // 39 with p = 10/11. After a day at 4 Hz 36 is asked for. A length more would find weaker clipping, after hours. A
  // shorter one would cost time: about the first hundred readings of a stretch are counted one by one, before most lie
  // amid.
  static constexpr std::size_t kStretchLengths = 4;
  [[nodiscard]] static constexpr std::int64_t judgements_of(std::size_t stretch) noexcept {
    return std::int64_t{3} << (2 * stretch);
  }
  // -ln 10⁻³: the end is known, so only chance within this stretch is to be excluded. Smaller: two readings at an old
  // end withhold a sound hold. Larger: an end that comes back shows later.
  static constexpr double kAtFoundEnd = 6.9;
  // Steps of rounding between the lowest and the highest reading of a motion. An end cut off by less than five steps is
  // not found anyway.
  static constexpr double kMoves = 10.0;
  // `readings` of `seen` are cut off at `at`; 0: none.
  struct CutOff {
    std::int64_t readings = 0;
    double at = 0.0;
    std::int64_t seen = 0;
  };
  struct End {
    Crest of_hold;
    std::array<Crest, kStretchLengths> of_stretches;
    double known = INFINITY;  // the end of the transducer's range, found before
    std::int64_t passed = 0;  // readings cut off below the hold's largest
    double passed_at = 0.0;   // the newest end at which they were
    double lost = 0.0;        // by them: relative loss of the fundamental times readings

    // Readings that are cut off at the hold's largest.
    [[nodiscard]] std::int64_t now(const Noise& noise, std::int64_t elsewhere) const noexcept {
      return of_hold.cut_off(noise, elsewhere, of_hold.top() == known ? Crest::kNone : Crest::kProof);
    }
    // A few readings at an end found before may be chance: less proof is asked for there, but some.
    [[nodiscard]] Crest::Proof proof_at(double top, double more) const noexcept {
      const bool found = top == known || (passed > 0 && top == passed_at);
      return {(found ? kAtFoundEnd : Crest::kProof.unlikely) + more, Crest::kProof.unlikely_runs + more};
    }
    // Adds readings cut off at an end that others went beyond. false: there are none.
    bool pass(const CutOff& cut_off) noexcept {
      if (cut_off.readings == 0) return false;
      passed += cut_off.readings;
      passed_at = cut_off.at;
      lost += lost_of(cut_off.readings, cut_off.seen);
      return true;
    }
    // The newest end at which readings were cut off, `now_cut_off` of them at the hold's largest.
    [[nodiscard]] double at(std::int64_t now_cut_off) const noexcept {
      return passed > 0 && now_cut_off == 0 ? passed_at : of_hold.top();
    }
    // Smaller readings change none of the crests.
    [[nodiscard]] double least() const noexcept {
      double least = of_hold.least();
      for (const Crest& crest : of_stretches) least = std::min(least, crest.least());
      return least;
    }
    [[nodiscard]] End of_next_hold(std::int64_t now_cut_off) const noexcept {
      End next;
      next.known = passed + now_cut_off > 0 ? at(now_cut_off) : known;
      return next;
    }
  };
  // What the stretches show; where several do, the one with the most readings that are cut off.
  [[nodiscard]] CutOff most_cut_off(const End& end, const Noise& noise, double more) const noexcept {
    CutOff most;
    if (!moves(noise)) return most;
    for (std::size_t s = 0; s < kStretchLengths; ++s) {
      const double top = end.of_stretches[s].top();
      if (!(top < end.of_hold.top())) continue;  // the hold's count has these readings
      const std::int64_t elsewhere =
          stuck_ - begun_[s].stuck - upper_.of_stretches[s].runs_at_top() - lower_.of_stretches[s].runs_at_top();
      const std::int64_t cut_off = end.of_stretches[s].cut_off(noise, elsewhere, end.proof_at(top, more));
      if (cut_off > most.readings) most = {cut_off, top, seen_ - begun_[s].seen};
    }
    return most;
  }
  void begin_stretch(std::size_t s) noexcept {
    upper_.of_stretches[s] = lower_.of_stretches[s] = {};
    begun_[s] = {seen_, stuck_};
  }
  // Computes low_ and high_ anew: after each change of a crest. A reading between them changes no crest. Most readings
  // are such, and cost two comparisons only.
  void find_amid() noexcept {
    high_ = upper_.least();
    low_ = -lower_.least();
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

  // Where a stretch begins in the hold.
  struct Beginning {
    std::int64_t seen = 0, stuck = 0;
  };

  End upper_, lower_;
  double low_ = INFINITY, high_ = -INFINITY;  // see find_amid()
  bool amid_ = false;                         // the newest reading lies between these
  std::int64_t seen_ = 0;                     // readings of the hold
  std::int64_t stuck_ = 0;                    // long runs of the hold
  std::int64_t periods_ = 0;                  // of the hold
  std::array<Beginning, kStretchLengths> begun_{};
};

}  // namespace dwell
