// Decides whether a reading belongs to the motion of those before it. Foreign readings do not: zeros of a gateway,
// repeats of an older answer, swapped words, codes for "no value".
//
// The last good readings predict the next one (motion_predictor.hpp). White noise σ gives the prediction error e the
// standard deviation a σ, with a the predictor's gain. s is the running median of |e| / a. A reading is out of the
// motion if
//
//   |e| > a · 12 s   This is 8 standard deviations of Gaussian noise: passed by chance once in 10^15 readings. The
//                    largest error is 1.4 medians with a harmonic that the predictor does not follow, 5 with jitter.
//   |e| > a ·  k s   for a reading that equals one of the last eight bit by bit, or a foreign one seen before. Noise σ
//                    makes it equal with the probability p < 8 q / (2 √π σ), q the rounding step. k is at least 3, and
//                    such that p exp(-(0.67 k)²/2) is 10^-8.
//
// To each limit is added what rounding can contribute at most, and the half width of the reading's instant times the
// steepest slope. An answer that was held up, with a half width beyond 1.5 medians, is judged but predicts nothing:
// it would make the readings after it look foreign. Nor does it count if its instant adds twice the variance of the
// noise or more. The fits give every reading the same weight, and this one deserves a third at most. While the noise
// is not known (before the drive is recognized, or with too few readings a period), an answer does not count beyond
// 5 medians. The start of the motion looks like noise for some hundred readings; so an answer beyond 5 medians never
// counts where fewer than one in ten are so late.
//
// A reading out of the motion waits. If the next one fits again, those that wait are foreign. Three in a row that go on
// evenly, or any four, are another motion (a knock, friction that turns round): they are given back and count.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/intake/answer_lateness.hpp"
#include "core/intake/foreign_readings.hpp"
#include "core/intake/motion_predictor.hpp"
#include "core/intake/plain_run.hpp"
#include "core/intake/prediction_errors.hpp"
#include "core/intake/recent_numbers.hpp"
#include "core/intake/waiting_readings.hpp"

namespace dwell {

// Of one channel, in any unit. Bound to one thread; real-time safe; about 0.2 µs a reading.
class MotionGate {
 public:
  using Reading = DatedReading;
  enum class Says : std::uint8_t {
    take,
    leave,      // foreign
    uncertain,  // of the motion, but its instant is too uncertain to count
    wait,       // not decided
    give_back,  // take the waiting() readings, the oldest first, then this one
  };

  // Judges the next reading. omega: rad/s; step: the rounding step (INFINITY: not known).
  Says judge(const Reading& reading, double omega, double step) noexcept;

  // Whether the readings may be judged as a run from the newest one on: `before` are the last ones.
  [[nodiscard]] bool plain(std::span<const double, PlainRun::kBefore> before, double omega) const noexcept {
    return errors_.known() && waiting_.count() == 0 && recent_.are(before.last<Recent::kRemembered>()) &&
           predictor_.even(before.last<MotionPredictor::kPoints>(), last_ns_, omega);
  }
  [[nodiscard]] std::int64_t newest_ns() const noexcept { return last_ns_; }
  // The time between the newest two readings; only while plain().
  [[nodiscard]] std::int64_t gap_ns() const noexcept { return predictor_.gap_ns(); }
  // Judges the first readings of a run that begins while plain(): those that judge() would take, with no need for
  // their instants' half width. step(): the rounding step, before each reading; took(number): after it. Shortens the
  // run to them.
  template <class Step, class Took>
  void take_plain(PlainRun& run, Step&& step, Took&& took) noexcept;

  // Whether the gate judges: the motion is known, and sampled densely enough.
  [[nodiscard]] bool active() const noexcept { return active_; }
  // The readings given back by the last judge().
  [[nodiscard]] std::span<const Reading> waiting() const noexcept { return waiting_.first(given_back_); }
  // Standard deviation of a reading's noise, estimated from the prediction errors; 0: not known.
  [[nodiscard]] double noise() const noexcept { return errors_.noise(); }

  [[nodiscard]] const ForeignReadings& foreign() const noexcept { return foreign_; }
  [[nodiscard]] bool held_up(const Reading& reading) const noexcept { return lateness_.held_up(reading.half_ns); }
  // Readings that did not count because of their instants: since construction, since restart().
  [[nodiscard]] std::uint64_t uncertain() const noexcept { return uncertain_.ever; }
  [[nodiscard]] std::uint64_t uncertain_in_hold() const noexcept { return uncertain_.in_hold; }
  void restart() noexcept {
    foreign_.restart();
    uncertain_.in_hold = 0;
  }

 private:
  using Recent = RecentNumbers<8>;
  static constexpr double kFar = 12.0;      // medians; at half of it (4 σ) a good reading fails once in 16 000
  static constexpr double kRounding = 4.0;  // steps: rounding alone gives e at most (1 + Σ|w|) / 2 = 2.5

  // A good reading, for the predictions that follow.
  void follow(const Reading& reading) noexcept {
    if (!lateness_.held_up(reading.half_ns)) predictor_.add(reading.t_ns, reading.value);
  }
  // What says of a reading of the motion: take, or that its instant is too uncertain.
  Says counts(bool certain) noexcept {
    if (certain) return Says::take;
    ++uncertain_.ever;
    ++uncertain_.in_hold;
    return Says::uncertain;
  }
  // The readings that wait are foreign.
  void leave_waiting() noexcept {
    for (const Reading& reading : waiting_.take()) foreign_.add(reading.value, false);
  }
  // The limit k for a reading that equals one of the last, in medians.
  [[nodiscard]] double tied_medians(double step) const noexcept;
  Says give_back(const Reading& newest, double relative) noexcept;

  MotionPredictor predictor_;
  Recent recent_;
  WaitingReadings waiting_;
  std::size_t given_back_ = 0;
  PredictionErrors errors_;
  AnswerLateness lateness_;
  bool active_ = false;
  std::int64_t last_ns_ = INT64_MIN;  // of the newest reading, taken or not
  struct {
    std::uint64_t ever = 0, in_hold = 0;
  } uncertain_;
  ForeignReadings foreign_;
};

// Each step is that of judge(), in the same order.
template <class Step, class Took>
void MotionGate::take_plain(PlainRun& run, Step&& step, Took&& took) noexcept {
  const double gain = predictor_.even_gain(), half_ns = run.half_ns();
  // Apart from the medians no reading depends on the judgement of the one before.
  std::array<double, PlainRun::kMost> errors, relatives;
  for (std::size_t i = 0; i < run.count(); ++i) {
    const double predicted = predictor_.predict_evenly(run.before(i, MotionPredictor::kPoints).data());
    errors[i] = std::abs(run.at(static_cast<std::ptrdiff_t>(i)) - predicted);
    relatives[i] = errors[i] / gain;
  }
  std::size_t taken = 0;
  for (; taken < run.count(); ++taken) {
    AnswerLateness lateness = lateness_;
    lateness.see(half_ns, false);
    const double step_now = step();
    if (lateness.held_up(half_ns) || !std::isfinite(step_now)) break;
    if (!(errors[taken] <= gain * kFar * errors_.median() + kRounding * step_now)) break;
    lateness_ = lateness;
    errors_.add(relatives[taken]);
    took(run.at(static_cast<std::ptrdiff_t>(taken)));
  }
  run.shorten(taken);
  if (taken == 0) return;
  given_back_ = 0;
  active_ = true;
  last_ns_ = run.last_ns();
  recent_.add_all(run.readings());
  predictor_.add_evenly(taken, last_ns_, run.before(taken, MotionPredictor::kPoints).first<MotionPredictor::kPoints>());
}

}  // namespace dwell
