// Shows the settling detector the windows of a hold: one window of all channels each quarter of a period.
//
// All windows that are compared are taken at one ω. If the best known ω has moved so far that it would show, the
// windows of this hold are taken anew.
#pragma once

#include <algorithm>
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

// Bound to one thread; real-time safe except for the constructor. Its arguments must outlive it.
class SettlingWindows {
 public:
  SettlingWindows(const Rig& rig, LiveChannels& live, const CountedData& data);

  [[nodiscard]] WindowLength& length() noexcept { return length_; }
  [[nodiscard]] const WindowLength& length() const noexcept { return length_; }

  // The drive is steady from now on.
  void begin_hold() noexcept;

  // The end of the first window to take, an index of blocks: the newest, or an older one where all are taken anew.
  // steady_serial: beginning of the hold.
  [[nodiscard]] int first_end(std::int64_t steady_serial) noexcept;
  // Takes the window of blocks [from, to). learn(c, squares, freedom) takes the channel's noise as blocks alone show it
  // (noise_of), and returns the best known variance; INFINITY: not known. false: the window could not be fitted.
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
  // Whether a channel's reading in the newest window may be used.
  [[nodiscard]] bool usable(int c) const noexcept { return readings_[static_cast<std::size_t>(c)].usable; }
  // The phasor that identifies the chain, relative to the table's: mean over the later half of the hold, or of the
  // newest window where there is none.
  [[nodiscard]] std::complex<double> phasor(int c) const noexcept;
  // Whether to identify the chain again: now and then, since its eigenvalues cost n³.
  [[nodiscard]] bool wants_chain(std::int64_t steady_serial) noexcept;
  // Judges the hold by the window that look() took. t_s: its end; time_constant_s: of the identified chain, NaN: not
  // known.
  [[nodiscard]] SettlingDetector::Verdict judge(int from, int to, double t_s, double time_constant_s) noexcept;
  // The verdict is settled. left_at_verdict(): what the windows left of the transient at the verdict, in the unit of
  // the channel's reading; 0 if the fit gave the verdict.
  void keep_left() noexcept;
  void forget_left() noexcept { std::fill(left_.begin(), left_.end(), 0.0); }
  [[nodiscard]] double left_at_verdict(int c) const noexcept { return left_[static_cast<std::size_t>(c)]; }

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
  WindowLength length_;
  SettlingDetector detector_;
  std::vector<HarmonicFit> fits_;  // of the newest window
  std::vector<SettlingDetector::Reading> readings_;
  std::vector<double> left_;
  double omega_ = 1.0;  // rad/s, at which the detector's windows were taken
  std::int64_t solve_at_serial_ = 0;
};

}  // namespace dwell
