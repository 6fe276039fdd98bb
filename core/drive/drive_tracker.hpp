// The tracker of the drive answers three questions. Does the table move? At which frequency? Is it still the steady
// motion with which the hold began?
//
// Each quarter of a period brings a window of the drive's channel. While a dwell settles, DriveMonitor compares windows
// with each other. Once data count, StepWatch compares each reading with the fit of these data. The window's phase is
// compared with that fit too: in time it shows a small error of frequency that amplitude and the window's own frequency
// do not show. SeenDrive keeps what messages tell.
#pragma once

#include <complex>
#include <cstdint>
#include <string>

#include "core/drive/drive.hpp"
#include "core/drive/drive_reference.hpp"
#include "core/drive/seen_drive.hpp"
#include "core/drive/step_watch.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/mains.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; real-time safe except for the constructor and functions that return text. Rig and reference must
// outlive it. Angular frequencies in rad/s.
class DriveTracker {
 public:
  DriveTracker(const Rig& rig, const DriveReference& reference);

  // The state at a window. dwell: one is on. measuring: its data count. counting: there are sums over all of these
  // data.
  struct During {
    bool dwell = false, measuring = false, counting = false;
  };
  // One window: its centre; the fit of the drive's channel about that centre; the phasor of the table's motion; and the
  // largest amplitude at a multiple of the fitted frequency that lies in the search range, m (rad).
  struct Window {
    std::int64_t centre_ns;
    const HarmonicFit& fit;
    std::complex<double> Y;
    double elsewhere = 0.0;
  };
  enum class Sight : std::uint8_t {
    rests,      // no motion in this window and the one before
    low,        // no motion in this window alone
    faint,      // a drive or noise: not enough to begin a dwell
    elsewhere,  // no motion at the window's frequency, but at a multiple of it: the drive has another frequency
    moves,
  };
  // Tells whether a window shows a drive. acquired_omega: ω from the window itself; NaN: not known.
  Sight see(const Window& window, double acquired_omega, const During& during) noexcept;
  // Whether the drive differs from that of this hold. Call it after see() with the same window. since_s: the window's
  // centre, from the hold's beginning. bend_rad: phase by which a known drift has turned the drive there. omega: ω of
  // the window's fit.
  [[nodiscard]] bool changed(const Window& window, double since_s, double bend_rad, double omega,
                             const During& during) noexcept;
  // Takes a reading of the drive's channel that counts, without the known transient. extra_u_s: as in StepWatch::add().
  void add(std::int64_t t_ns, double value, double extra_u_s) noexcept { watch_.add(t_ns, value, extra_u_s); }

  // Begins to record what a new drive does, for unsteady_reason().
  void arm() noexcept { seen_.arm(); }
  // Begins a hold: the drive is taken as steady from now on.
  void begin_hold() noexcept;
  // Drops the reference of StepWatch, since its data count no more.
  void stop_counting() noexcept;
  // What the data that count tell of the drive: their fit of its channel, about t_ref_ns at omega.
  struct Known {
    std::int64_t t_ref_ns;
    const HarmonicFit& fit;
    double amplitude;       // of the motion, m (rad)
    double omega, u_omega;  // by all channels
    double drift;           // rad/s²
    double rounding_u;      // standard uncertainty of the reading's phasor by the device's rounding
  };
  // Takes a new reference. sampling: of the drive's channel.
  void refer(const Known& known, const SamplingRegularity& sampling) noexcept;

  // ω from the phase's advance in this hold; NaN: not known yet.
  [[nodiscard]] double omega() const noexcept { return monitor_.omega(); }
  // Standard uncertainty of ω by the data that count, as of the last refer().
  [[nodiscard]] double u_omega() const noexcept { return hold_.u_omega; }
  // Whether the frequency is known and outside the search range. False if the rig file states a frequency.
  [[nodiscard]] bool out_of_search() const noexcept;
  // How many of the newest quarter periods may hold another drive.
  [[nodiscard]] int doubtful_quarters() const noexcept;
  // The same once the drive has changed: how many there are since it was beyond doubt.
  [[nodiscard]] int quarters_of_change() const noexcept;

  // Messages: the table does not count as moving; it has moved for `seconds` without being steady.
  [[nodiscard]] std::string at_rest_reason() const { return seen_.at_rest(rig_); }
  // Whether the amplitude of the drive since arm() has changed by more than Rig::tolerance.
  [[nodiscard]] bool seen_swinging() const noexcept { return seen_.swings(rig_); }
  [[nodiscard]] std::string unsteady_reason(double seconds, const SamplingRegularity& sampling) const {
    return seen_.unsteady(rig_, seconds, sampling);
  }

 private:
  [[nodiscard]] double u_of(const Window& window, const During& during) const noexcept;
  bool slipped(const Window& window, const During& during) noexcept;

  const Rig& rig_;
  const DriveReference& reference_;
  DriveMonitor monitor_;  // while settling
  StepWatch watch_;       // while measuring
  SeenDrive seen_;
  struct Hold {
    std::int64_t t_ref_ns = 0;
    double phase_rad = 0.0, omega = 0.0, u_omega = 0.0;
    double sigma2 = 0.0;  // of the table's residuals
  } hold_;                // the table's phasor in this dwell, as of the last refer()
  int low_windows_ = 0, slips_ = 0, since_in_phase_ = 0;
};

}  // namespace dwell
