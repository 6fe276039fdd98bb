// The settling detector: holds until what is left of the transient is small, and says from where the data count.
//
// It looks at windows of one period that end at each quarter of a period. From a window come, per channel, the mean and
// the phasors relative to the table's (so that a frequency slightly off turns nothing) and the residual variance, the
// places where a transient shows: a mode close to the drive or a harmonic in the phasors, any other in the residuals.
// Both are compared with those of all earlier windows since the drive has been steady. A transient that decays with
// time constant T and that differs by D between two windows a time Δ apart has at most
//
//   left = D q / (1 - q),   q = exp(-Δ/T)
//
// left at the later one. D is taken with three standard deviations of its noise on top, so that what cannot be told yet
// is not believed to be gone: a mode that looks constant over one window (Δ « T) holds until Δ is long enough to tell,
// and so does noise. Of all earlier windows the one with the lowest bound decides. T is the slowest of the identified
// chain's eigenvalues (docs/method.md, Settling); where there is none, a sixth of the time that the detector has been
// looking, and all windows within the rest of it must agree.
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

class SettlingDetector {
 public:
  // channels: those that are watched; tolerance: the transient allowed, relative to a channel's steady amplitude.
  // All memory is allocated here.
  SettlingDetector(int channels, double tolerance);

  // One channel in one window, in any unit of its own.
  struct Reading {
    std::complex<double> relative;  // phasor over the table's phase
    // Mean, and phasors of the higher harmonics over as many times the table's phase: a mode near one of them hides
    // there from both the fundamental and the residuals.
    std::array<std::complex<double>, kMaxHarmonics> others{};
    double u = 0.0;         // standard deviation of either component of it, by the noise alone
    double variance = 0.0;  // of the residuals of the harmonic fit: noise, transient, higher harmonics
    double noise = 0.0;     // variance of the noise alone
    double samples = 0.0;   // in the window
    bool usable = false;    // no: the channel is left out
  };

  // Forgets everything; the drive is steady from now on as far as known.
  void restart() noexcept;

  struct Verdict {
    bool settled = false;
    std::int64_t from_serial = 0;  // settled: the first quarter block that counts
    double settles_in_s = 0.0;     // not settled: expected time left; NaN: not known
    int worst_channel = -1;        // not settled: which channel holds it up; -1: too little seen yet
    double worst_left = 0.0;       // its transient relative to what is allowed
  };

  // Takes the window that covers quarter blocks [first, last] and ends at t_s. table_amplitude, table_u: of the drive,
  // and its standard deviation. time_constant_s: T, NaN if not known. O(history · channels), no allocation.
  Verdict update(std::int64_t first, std::int64_t last, double t_s, double table_amplitude, double table_u,
                 std::span<const Reading> readings, double period_s, double time_constant_s) noexcept;

  // Mean over the windows of the later half of the hold, what a provisional identification should rest on: less of the
  // transient and of the noise than the newest window has. Not usable channels: 0.
  [[nodiscard]] std::complex<double> later_mean(int channel) const noexcept;

  // After a settled verdict: how far, in the rms, a channel's windows in the first time constant that counts lie from
  // the newest one: transient and noise together, in the channel's own unit.
  [[nodiscard]] double left(int channel) const noexcept { return left_[static_cast<std::size_t>(channel)]; }

 private:
  static constexpr int kHistory = 192;     // windows remembered; beyond, every second one is dropped
  static constexpr double kSure = 3.0;     // standard deviations within which a difference is noise
  static constexpr int kGroup = 4;         // windows of a period
  static constexpr double kPeriods = 2.0;  // that must agree before anything is said

  struct Window {
    std::int64_t first, last;
    double t_s, table_amplitude, table_u, time_constant_s;
  };
  [[nodiscard]] Reading& reading(int window, int channel) noexcept;
  [[nodiscard]] const Reading& reading(int window, int channel) const noexcept;
  void remember(const Window& window, std::span<const Reading> readings) noexcept;
  [[nodiscard]] double allowed(const Reading& now) const noexcept;
  [[nodiscard]] bool agrees(int window, const Window& now, std::span<const Reading> readings) noexcept;

  int channels_;
  double tolerance_;
  std::vector<Window> windows_;
  std::vector<Reading> readings_;
  std::vector<double> left_;
  int stride_ = 1, skipped_ = 0;
};

}  // namespace dwell
