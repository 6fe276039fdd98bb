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
#include <cstddef>
#include <cstdint>

namespace dwell::handon {

// The equations for one set of readings' instants. They do not depend on the values: channels that are read in the same
// scans ask for the same set one after the other, and share the work.
class SharedInstants {
 public:
  static constexpr int kReadings = 32;
  using Instants = std::array<std::int64_t, kReadings>;
  using Values = std::array<double, kReadings>;

  // From here on of these readings; the oldest stands at `oldest`. Cost: 4 µs, or nothing where they are the same.
  void take(const Instants& t_ns, std::size_t oldest, double interval_ns);
  // x becomes (K + εI)⁻¹ x.
  void solve(Values& x) const;
  // (K + εI)⁻¹ at a reading's place on the diagonal.
  [[nodiscard]] double inverse_at(std::size_t place) const;
  // k(t).
  [[nodiscard]] const Values& covariance(std::int64_t at_ns);

 private:
  [[nodiscard]] double angle(std::int64_t at_ns) const noexcept;  // 2πB(t - oldest reading)

  Instants t_ns_{};
  double interval_ns_ = 0.0;  // 0: nothing has been taken
  std::int64_t oldest_ns_ = 0, at_ns_ = INT64_MIN;
  Values angles_{}, covariance_{};
  std::array<double, static_cast<std::size_t>(kReadings) * kReadings> factor_{};  // Cholesky, lower, column by column
};

// Of one channel. A value; bound to one thread. 0.6 kB.
class Resampler {
 public:
  static constexpr int kReadings =
      SharedInstants::kReadings;         // taken into account: half before, half behind. Twice as many cost four times
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
  // those before the 16th of the newest 32 readings' successor. Cost: 1 µs a reading, and 4 µs where `shared` has other
  // instants; any object will do, one for all channels is best.
  template <class Emit>
  void push(SharedInstants& shared, std::int64_t t_ns, double x, const Emit& emit) {
    if (!add(shared, t_ns, x)) return;
    for (; next_ns_ < after_ns(); next_ns_ += step_ns_) emit(next_ns_, value_at(shared, next_ns_));
  }

  [[nodiscard]] const Check& check() const noexcept { return check_; }

 private:
  // false: there are not enough readings, or nothing to tell between the middle two.
  [[nodiscard]] bool add(SharedInstants& shared, std::int64_t t_ns, double x);
  void solve(SharedInstants& shared, bool check);
  [[nodiscard]] double value_at(SharedInstants& shared, std::int64_t t_ns) const;
  [[nodiscard]] std::int64_t after_ns() const noexcept;  // the reading behind the middle

  double interval_ns_;
  std::int64_t step_ns_, next_ns_ = 0;
  std::uint64_t count_ = 0;          // readings of the stretch; reading n stands at n % kReadings
  SharedInstants::Instants t_ns_{};  // the newest
  SharedInstants::Values x_{};
  SharedInstants::Values weight_{};  // (K + εI)⁻¹ (x - m)
  double mean_ = 0.0;
  Check check_;
};

}  // namespace dwell::handon
