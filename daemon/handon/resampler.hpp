// Resamples readings at irregular instants to even instants: computes the band-limited signal that agrees with the
// readings around each instant.
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
// The error is measured on the readings themselves: now and then one reading is estimated from the others. The
// difference is an upper figure: it contains the noise of the reading, and the gap makes this estimate harder than
// those that are handed out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell::handon {

// The equations for one set of instants. They do not depend on the readings' values. Channels that are read in the same
// scans need the same set one after the other, and so share the work.
class SharedInstants {
 public:
  static constexpr int kReadings = 32;
  using Instants = std::array<std::int64_t, kReadings>;
  using Values = std::array<double, kReadings>;

  // Takes the instants of these readings; the oldest is at index `oldest`. Cost: 4 µs, or nothing if they are the same.
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
  Values angles_{}, sines_{}, cosines_{};
  Values covariance_{};
  std::array<double, static_cast<std::size_t>(kReadings) * kReadings> factor_{};  // Cholesky, lower, column by column
};

// Of one channel. A value; bound to one thread. 0.6 kB.
class Resampler {
 public:
  // Readings around an instant that its estimate uses: about half before, half behind. Doubled, the equations
  // cost four times as much.
  static constexpr int kReadings = SharedInstants::kReadings;
  // Fewest readings of a stretch worth writing. The first and the last 16 serve as neighbours only: so at least as much
  // is written as is lost at either end. Half as many: no even instant, or a few that rest on the same readings. Twice
  // as many: 48 readings more are lost between two gaps.
  static constexpr int kFewest = kReadings + kReadings / 2;
  // The equations of one set of readings serve the even instants up to so many readings behind the middle. 0: nearly
  // each reading needs equations of its own, which cost five times as much in all; the rms errors of the tests' sines
  // are up to a fifth smaller.
  static constexpr int kServed = 3;
  // B as a share of the rate, < 0.5. Raised, kReadings must grow for the same error; lowered, less of the signal is
  // kept.
  static constexpr double kBand = 0.35;
  // A longer interval than this, in usual intervals, ends a stretch. One missing reading is bridged.
  static constexpr double kGap = 2.5;

  // Errors of estimating a reading from the others.
  struct Check {
    std::uint64_t count = 0;
    double sum_of_squares = 0.0, largest = 0.0;
    [[nodiscard]] double rms() const noexcept;
  };

  // interval_ns: usual time between readings, > 0. step_ns: between the even instants, > 0.
  Resampler(double interval_ns, std::int64_t step_ns) noexcept : interval_ns_(interval_ns), step_ns_(step_ns) {}

  // A stretch without gaps begins; the first even instant is at `first_ns`, not before the 16th reading.
  void begin(std::int64_t first_ns) noexcept;

  // Takes the next reading; t_ns must not go back. Once an even instant lies before the 17th of the newest 32 readings,
  // calls emit(t_ns, y) for it and those up to kServed readings later. Cost: one reading in four 1 µs, and 4 µs if
  // `shared` holds other instants. One `shared` object for all channels is best.
  template <class Emit>
  void push(SharedInstants& shared, std::int64_t t_ns, double x, const Emit& emit) {
    if (!add(shared, t_ns, x)) return;
    for (; next_ns_ < behind_middle_ns(kServed); next_ns_ += step_ns_) emit(next_ns_, value_at(shared, next_ns_));
  }

  [[nodiscard]] const Check& check() const noexcept { return check_; }

 private:
  // false: there are not enough readings, or no even instant between the middle two.
  [[nodiscard]] bool add(SharedInstants& shared, std::int64_t t_ns, double x);
  void solve(SharedInstants& shared, bool check);
  [[nodiscard]] double value_at(SharedInstants& shared, std::int64_t t_ns) const;
  // Of the reading behind the middle, and of those that follow it: 0, 1 …
  [[nodiscard]] std::int64_t behind_middle_ns(int further) const noexcept;

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
