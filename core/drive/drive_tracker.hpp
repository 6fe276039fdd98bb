// The tracker of the drive answers three questions. Does the table move? At which frequency? Is it still the steady
// motion with which the hold began?
//
// Each quarter of a period brings a window of the drive's channel. Three watch it: DriveMonitor compares windows with
// each other, which is all there is while a dwell settles; once the data count, StepWatch compares each reading with
// what they predict, and the window's phase is held against theirs: a frequency a little off shows in time, wherever
// amplitude and the window's own frequency show nothing. SeenDrive remembers what to tell people.
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

// Bound to one thread; real-time safe but for the constructor and what makes text. What it is given must outlive it.
// Angular frequencies in rad/s.
class DriveTracker {
 public:
  DriveTracker(const Rig& rig, const DriveReference& reference);

  // What goes on while a window is looked at. counting: there are sums over all data that count.
  struct During {
    bool dwell = false, measuring = false, counting = false;
  };
  // One window: its centre, the fit of the drive's channel about it, and the motion that this reads, m (rad).
  struct Window {
    std::int64_t centre_ns;
    const HarmonicFit& fit;
    std::complex<double> Y;
  };
  enum class Sight : std::uint8_t {
    rests,  // no drive, in two windows one after the other
    low,    // no drive, in this window alone
    faint,  // a drive, but noise might be taken for it: not enough to begin a dwell
    moves,
  };
  // What a window of the table shows. acquired_omega: ω by the window itself; NaN: not known.
  Sight see(const Window& window, double acquired_omega, const During& during) noexcept;
  // Whether the drive is another than in this hold; after see(), of the same window. since_s: from the hold's
  // beginning. bend_rad: by what a known drift has turned the drive at the window. omega: that the window was fitted
  // at.
  [[nodiscard]] bool changed(const Window& window, double since_s, double bend_rad, double omega,
                             const During& during) noexcept;
  // A reading of the drive's channel that counts, the known transient taken out; late_s: as StepWatch::add.
  void add(std::int64_t t_ns, double value, double late_s) noexcept { watch_.add(t_ns, value, late_s); }

  // A drive begins to be looked at.
  void arm() noexcept { seen_.arm(); }
  // The drive is taken as steady from now on.
  void begin_hold() noexcept;
  // The data that it was held against count no more.
  void stop_counting() noexcept;
  // What the data that count say of it: their fit of the drive's channel, about t_ref_ns at omega.
  struct Known {
    std::int64_t t_ref_ns;
    const HarmonicFit& fit;
    double amplitude;       // of the motion, m (rad)
    double omega, u_omega;  // by all channels
    double drift;           // rad/s²
    double rounding_u;      // standard uncertainty of the reading's phasor by the device's rounding
  };
  // sampling: of the drive's channel.
  void refer(const Known& known, const SamplingRegularity& sampling) noexcept;

  // By the advance of its phase in this hold; NaN: not known yet.
  [[nodiscard]] double omega() const noexcept { return monitor_.omega(); }
  // Standard uncertainty of ω by the data that count, when they were last counted anew.
  [[nodiscard]] double u_omega() const noexcept { return hold_.u_omega; }
  // Its frequency is beyond the range that is searched.
  [[nodiscard]] bool out_of_search() const noexcept;
  // Of the newest quarters of a period, those that may hold another drive.
  [[nodiscard]] int doubtful_quarters() const noexcept;
  // The same of a drive that has changed: how many go back to where it was beyond doubt.
  [[nodiscard]] int quarters_of_change() const noexcept;

  // In words, of a table that does not count as moving; of one that has moved for so long without being steady.
  [[nodiscard]] std::string at_rest_reason() const { return seen_.at_rest(rig_); }
  [[nodiscard]] std::string unsteady_reason(double seconds) const { return seen_.unsteady(rig_, seconds); }

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
  } hold_;                // the table's phasor in this dwell, as last counted anew
  int low_windows_ = 0, slips_ = 0, since_in_phase_ = 0;
};

}  // namespace dwell
