// Does a reading belong to the motion of those before it? Zeros of a gateway, repeats of an older answer, swapped words
// and codes for "no value" do not.
//
// The last good readings predict the next one (motion_predictor.hpp). A reading is judged by its prediction error e
// over the predictor's gain a (of white noise σ, e has the standard deviation a σ), against the running median s of |e|
// / a:
//
//   |e| > a · 12 s   8 standard deviations of Gaussian noise: passed by chance once in 10^15 readings. A harmonic that
//                    the predictor does not follow has a largest error of 1.4 medians, jitter of the instants of 5.
//   |e| > a ·  k s   for a reading that is bit by bit one of the last eight, or a foreign one seen before. Noise σ
//                    makes it so with the probability p < 7 q / (2 √π σ), q the rounding step; k, at least 3, is where
//                    p exp(-(0.67 k)²/2) is 10^-8.
//
// Rounding adds what it can at most, and the half width of the reading's instant times the slope.
//
// What is beyond waits. The next reading that fits again makes those that wait foreign. Three in a row that go on
// evenly, or four whatever they do, are another motion (a knock, friction that turns round): they are given back and
// count.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/intake/foreign_readings.hpp"
#include "core/intake/motion_predictor.hpp"
#include "core/intake/recent_numbers.hpp"

namespace dwell {

// Of one channel, in any unit. Bound to one thread; real-time safe; about 0.2 µs a reading.
class MotionGate {
 public:
  struct Reading {
    std::int64_t t_ns = 0;
    double value = 0.0;
    std::uint32_t half_ns = 0;
    std::uint32_t refresh_half_ns = 0;  // of a held register: its refresh came at t_ns ± this, ns
  };
  enum class Says : std::uint8_t {
    take,
    leave,      // foreign
    wait,       // not decided
    give_back,  // take those that wait(), oldest first, and then this one
  };

  // The next reading, ω (rad/s) and the rounding step (INFINITY: not known).
  Says judge(const Reading& reading, double omega, double step) noexcept;

  // Whether the next reading is judged: the motion is known, and sampled densely enough.
  [[nodiscard]] bool active() const noexcept { return active_; }
  // Those to be given back.
  [[nodiscard]] std::span<const Reading> waiting() const noexcept { return {waiting_.data(), given_back_}; }
  // Standard deviation of a reading's noise, as far as the predictor shows it; 0: not known.
  [[nodiscard]] double noise() const noexcept { return seen_ > kFewest ? median_ / 0.6745 : 0.0; }

  [[nodiscard]] const ForeignReadings& foreign() const noexcept { return foreign_; }
  void restart() noexcept { foreign_.restart(); }

 private:
  using Recent = RecentNumbers<8>;
  static constexpr std::size_t kEven = 3, kMost = 4;
  static constexpr int kFewest = 40;    // readings before anything is judged: the median is known to 20 % by then
  static constexpr double kFar = 12.0;  // medians; halved: 4 σ, once in 16 000 readings
  static constexpr double kTied = 3.0, kTiedByChance = 1e-8;  // medians, at least; see above
  static constexpr double kRounding = 4.0;  // steps: e of rounding alone is at most (1 + Σ|w|) / 2, which is 2.5
  static constexpr double kTiedRounding = 2.5;
  static constexpr double kRefresh = 5.0;  // 1 + Σ|w|: the instants of the points are known no better
  static constexpr double kLearn = 0.02;   // relative step of the median: it follows a decay of 1 % a reading
  static constexpr double kJumped = 6.0;   // the median is at least the error of a jump over this

  [[nodiscard]] bool even(const Reading& newest, double limit) const noexcept;
  // How far off, in medians, a reading must be that is one of the last.
  [[nodiscard]] double tied_medians(double step) const noexcept;
  Says give_back(const Reading& newest, double relative) noexcept;

  MotionPredictor predictor_;
  Recent recent_;
  std::array<Reading, kMost - 1> waiting_{};
  std::size_t waits_ = 0, given_back_ = 0;
  double median_ = 0.0;
  int seen_ = 0;
  bool active_ = false;
  std::int64_t last_ns_ = INT64_MIN;  // of the newest reading, taken or not
  ForeignReadings foreign_;
};

}  // namespace dwell
