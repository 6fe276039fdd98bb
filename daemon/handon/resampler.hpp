// Even instants from readings at instants of their own: the value of the band-limited signal that agrees with the
// readings around it.
//
// The signal is taken as random with a flat spectrum up to B and nothing above it. Its covariance over a time τ is
// sinc(2Bτ), so the best linear estimate at t from the 32 readings around t (Gauss-Markov, "simple kriging") is
//
//   y(t) = m + k(t)ᵀ (K + ε I)⁻¹ (x - m),   K_ij = sinc(2B(t_i - t_j)),  k_i(t) = sinc(2B(t - t_i))
//
// with m the mean of these readings. B is 0.35 of the channel's rate: 70 % of what even readings could carry. Seen on
// sines up to 0.25 of the rate, readings up to a fifth of an interval off their places: errors below 1e-5 of the
// amplitude, also where one reading is missing. What lies above B is not represented.
//
// How well that holds is told by the readings themselves: now and then one is estimated from the others, without it.
// What it is off by holds its own noise as well, and the gap that it leaves makes the estimate harder than any that is
// handed out. So it is an upper figure.
#pragma once

#include <array>
#include <cstdint>

namespace dwell::handon {

// Of one channel. A value; bound to one thread. 0.6 kB.
class Resampler {
 public:
  static constexpr int kReadings = 32;   // taken into account: half before, half behind. Twice as many cost four times
  static constexpr double kBand = 0.35;  // B in units of the rate. Higher: more readings would be needed
  // A longer interval, in units of the usual one, ends a stretch. One missing reading is bridged.
  static constexpr double kGap = 2.5;

  // What estimating a reading from the others was off by.
  struct Check {
    std::uint64_t count = 0;
    double sum_of_squares = 0.0, largest = 0.0;
    [[nodiscard]] double rms() const noexcept;
  };

  // interval_ns: usual time between readings, > 0. step_ns: between the even instants, > 0.
  Resampler(double interval_ns, std::int64_t step_ns) noexcept : interval_ns_(interval_ns), step_ns_(step_ns) {}

  // A stretch without gaps begins; the first even instant is at `first_ns`, not before the 16th reading.
  void begin(std::int64_t first_ns) noexcept;

  // Takes the next reading; t_ns must not go back. Hands the even instants that can now be told to `emit(t_ns, y)`:
  // those before the 16th of the newest 32 readings' successor. Cost: about 10 µs a reading.
  template <class Emit>
  void push(std::int64_t t_ns, double x, const Emit& emit) {
    if (!add(t_ns, x)) return;
    for (; next_ns_ < after_ns(); next_ns_ += step_ns_) emit(next_ns_, value_at(next_ns_));
  }

  [[nodiscard]] const Check& check() const noexcept { return check_; }

 private:
  // false: there are not enough readings, or nothing to tell between the middle two.
  [[nodiscard]] bool add(std::int64_t t_ns, double x);
  void solve(bool check);
  [[nodiscard]] double value_at(std::int64_t t_ns) const noexcept;
  [[nodiscard]] std::int64_t after_ns() const noexcept;          // the reading behind the middle
  [[nodiscard]] double angle(std::int64_t t_ns) const noexcept;  // 2πB(t - oldest reading)

  double interval_ns_;
  std::int64_t step_ns_, next_ns_ = 0;
  std::uint64_t count_ = 0;                     // readings of the stretch; reading n stands at n % kReadings
  std::array<std::int64_t, kReadings> t_ns_{};  // the newest
  std::array<double, kReadings> x_{};
  std::array<double, kReadings> weight_{};  // (K + εI)⁻¹ (x - m)
  double mean_ = 0.0;
  Check check_;
};

}  // namespace dwell::handon
