// What the windows of a hold show of its transient: one window of all channels each quarter of a period, compared with
// each other by the settling detector.
//
// Windows are compared, so all are taken at one ω: when the best known has moved by a part of the tolerance that would
// show, those of this hold are taken anew.
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "core/drive/window_length.hpp"
#include "core/dwell/counted_data.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/intake/live_channels.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/settling.hpp"

namespace dwell {

// Bound to one thread; real-time safe but for the constructor. What it is given must outlive it.
class SettlingWindows {
 public:
  SettlingWindows(const Rig& rig, LiveChannels& live, const CountedData& data, WindowLength& length);

  // The drive is steady from now on.
  void begin_hold() noexcept;

  // The end of the first window to look at, an index of blocks: the newest, or an older one where all are taken anew.
  // steady_serial: where the hold begins.
  [[nodiscard]] int first_end(std::int64_t steady_serial) noexcept;
  // Takes the window of blocks [from, to). learn(c, squares, freedom) is told of each channel what blocks alone show of
  // its noise (take_noise), and returns the variance of its noise as known by now; INFINITY: it is not. false: it could
  // not be fitted.
  template <class Learn>
  bool look(int from, int to, std::int64_t now_ns, Learn&& learn) {
    if (!fit(from, to)) return false;
    for (int c = 0; c < live_.count(); ++c) {
      const bool watched = is_watched(c, now_ns);
      if (watched && too_few_samples(c)) {
        length_.lengthen();
        return false;
      }
      double noise = 0.0;
      if (watched && fits_[static_cast<std::size_t>(c)].usable) {
        const Noise seen = noise_of(c, from, to);
        noise = learn(c, seen.squares, seen.freedom);
        live_[c].see_residuals(std::sqrt(fits_[static_cast<std::size_t>(c)].sigma2));
      }
      take(c, watched, noise);
    }
    return true;
  }
  // A channel's reading in the newest window may be used.
  [[nodiscard]] bool usable(int c) const noexcept { return readings_[static_cast<std::size_t>(c)].usable; }
  // The phasor to identify the chain by, relative to the table's: of the later half of the hold, of the newest window
  // where there is none.
  [[nodiscard]] std::complex<double> phasor(int c) const noexcept;
  // Whether the chain is to be identified anew: now and then, for its eigenvalues cost n³.
  [[nodiscard]] bool wants_chain(std::int64_t steady_serial) noexcept;
  // Judges the hold by the window that look() has taken. time_constant_s: of the identified chain; NaN: not known. t_s:
  // where the window ends.
  [[nodiscard]] SettlingDetector::Verdict judge(int from, int to, double t_s, double time_constant_s) noexcept;
  // After a settled verdict: as SettlingDetector::left.
  [[nodiscard]] double left(int c) const noexcept { return detector_.left(c); }

 private:
  struct Noise {
    double squares = 0.0, freedom = 0.0;
  };
  [[nodiscard]] const HarmonicFit& table() const noexcept { return fits_[static_cast<std::size_t>(live_.drive())]; }
  // Relative standard uncertainty of the table's phasor.
  [[nodiscard]] double table_u() const noexcept;
  [[nodiscard]] bool fit(int from, int to) noexcept;
  [[nodiscard]] bool is_watched(int c, std::int64_t now_ns) const noexcept;
  [[nodiscard]] bool too_few_samples(int c) const noexcept;
  [[nodiscard]] Noise noise_of(int c, int from, int to) const noexcept;
  void take(int c, bool watched, double noise) noexcept;

  const Rig& rig_;
  LiveChannels& live_;
  const CountedData& data_;
  WindowLength& length_;
  SettlingDetector detector_;
  std::vector<HarmonicFit> fits_;  // of the newest window
  std::vector<SettlingDetector::Reading> readings_;
  double omega_ = 1.0;  // rad/s, at which the detector's windows were taken
  std::int64_t solve_at_serial_ = 0;
};

}  // namespace dwell
