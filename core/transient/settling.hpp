// Decides by comparing windows whether a rig has settled, and from where its data count (docs/method.md, Settling). It
// serves rigs without masses, and others until the poles of their natural oscillations are known.
//
// A window is one period long and ends at a quarter of a period. It gives, per channel, the mean, the phasors relative
// to the table's, and the variance of the residuals. Relative phasors do not turn where the frequency is slightly off.
// A transient close to the drive or a harmonic shows in the phasors, any other in the residuals. Each window is
// compared with all earlier ones since the drive has been steady. A transient with time constant T that differs by D
// between two windows a time Δ apart has at most
//
//   left = D q / (1 - q),   q = exp(-Δ/T)
//
// left at the later one. D includes three standard deviations of its noise. So a mode that looks constant over one
// window (Δ « T) prevents a verdict until Δ is long enough to tell, and so does noise. Of all earlier windows the one
// with the lowest bound decides. T is that of the slowest of the identified chain's eigenvalues. Where there is none, T
// is a sixth of the time that the detector has been looking, and all windows within the rest of that time must agree.
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
  // channels: number watched. tolerance: transient allowed, relative to a steady amplitude. All memory is allocated
  // here.
  SettlingDetector(int channels, double tolerance);

  // One channel in one window, in any unit of its own.
  struct Reading {
    std::complex<double> relative;  // phasor of the fundamental relative to the table's phase
    // Mean, and phasors of the higher harmonics relative to as many times the table's phase. A mode near one of them
    // shows in neither the fundamental nor the residuals.
    std::array<std::complex<double>, kMaxHarmonics> others{};
    double u = 0.0;         // standard deviation of either component of `relative`, by the noise alone
    double variance = 0.0;  // of the residuals of the harmonic fit: noise, transient, higher harmonics
    double noise = 0.0;     // variance of the noise alone
    double samples = 0.0;   // in the window
    bool usable = false;    // false: the channel is left out
  };

  // Forgets everything. Call where a steady drive begins.
  void restart() noexcept;

  struct Verdict {
    bool settled = false;
    std::int64_t from_serial = 0;  // settled: the first quarter block that counts
    double settles_in_s = 0.0;     // not settled: expected time left; NaN: not known
    int worst_channel = -1;        // not settled: which channel holds it up; -1: too little seen yet
    double worst_left = 0.0;       // its transient relative to what is allowed
  };

  // Adds the window of quarter blocks [first, last], which ends at t_s, and judges. table_amplitude, table_u: of the
  // drive, and its standard deviation. time_constant_s: T, NaN if not known. O(history · channels), no allocation.
  Verdict update(std::int64_t first, std::int64_t last, double t_s, double table_amplitude, double table_u,
                 std::span<const Reading> readings, double period_s, double time_constant_s) noexcept;

  // Mean of `relative` over the windows of the later half of the hold, for a provisional identification. It has less of
  // the transient and of the noise than the newest window. 0: the channel is not usable.
  [[nodiscard]] std::complex<double> later_mean(int channel) const noexcept;

  // After a settled verdict: rms distance of a channel's windows in the first time constant that counts from the newest
  // one. It holds transient and noise, in the channel's own unit.
  [[nodiscard]] double left(int channel) const noexcept { return left_[static_cast<std::size_t>(channel)]; }

 private:
  static constexpr int kHistory = 192;  // windows remembered; beyond, every second one is dropped

  struct Window {
    std::int64_t first, last;
    double t_s, table_amplitude, table_u, time_constant_s;
  };
  [[nodiscard]] Reading& reading(int window, int channel) noexcept;
  [[nodiscard]] const Reading& reading(int window, int channel) const noexcept;
  void remember(const Window& window, std::span<const Reading> readings) noexcept;
  [[nodiscard]] double allowed(const Reading& now) const noexcept;
  [[nodiscard]] bool agrees(int window, const Window& now, std::span<const Reading> readings) const noexcept;
  // The decay of the transient. It bounds what is left.
  struct Decay {
    double T;           // time constant, s
    double as_it_is_s;  // windows younger than this overlap the newest: their difference counts undiminished
  };
  [[nodiscard]] Decay decay(const Window& now, double period_s) const noexcept;
  [[nodiscard]] double most_left(int channel, const Reading& newest, double t_s, const Decay& decay) const noexcept;
  [[nodiscard]] double spread(int channel, const Reading& newest, int from, double T) const noexcept;

  int channels_;
  double tolerance_;
  std::vector<Window> windows_;
  std::vector<Reading> readings_;
  std::vector<double> left_;
  int stride_ = 1, skipped_ = 0;
};

}  // namespace dwell
