// Tells the model of the transient the state of a hold at one moment; plain data. A hold is the time since the drive
// has been steady. The pipeline fills HoldNow in before each call, so that the model keeps no pointer to the pipeline.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/fit/blocks.hpp"
#include "core/fit/mains.hpp"

namespace dwell {

// Periods left out at the beginning of a hold: they may hold the end of the motion before.
inline constexpr double kUnsure = 1.0;
// Periods that must be seen before anything is said of them. In one, a transient of about the drive's frequency looks
// steady. Doubled, every verdict comes two periods later.
inline constexpr double kPeriodsToTell = 2.0;
// Quarters of a period that a dwell must keep.
inline constexpr int kFewestQuarters = 6;
// Variance, in rounding steps squared, of readings with noise of half a step: 1/4 of noise, 1/12 of rounding.
inline constexpr double kRounded = 0.25 + 1.0 / 12;

// One channel, as the fit must know it.
struct FittedChannel {
  bool watched = false;                // it delivers, and its readings may be fitted
  bool imposed = false;                // it shows the table, whose motion is imposed and has no transient
  double reference = 0.0;              // a value near its mean, SI
  double refresh_half_s = 0.0;         // the instants of its readings are known to ± this, on average
  double widest_refresh_half_s = 0.0;  // the least known of them
  int transaction = 0;                 // channels of one transaction are read at one instant
  double step = std::numeric_limits<double>::quiet_NaN();  // rounding step of the readings, SI; not finite: not known
  SamplingRegularity sampling;

  // Whether residuals of that variance show less noise than half a step.
  [[nodiscard]] bool hides(double variance) const noexcept {
    return std::isfinite(step) && variance < step * step * kRounded;
  }
};

struct HoldNow {
  std::int64_t now_ns = 0;     // instant of the newest record
  std::int64_t steady_ns = 0;  // where the hold begins
  double omega = 1.0;          // of the drive as best known, rad/s
  bool omega_given = false;    // ω is stated or measured by pulses; the samples do not refine it
  int drive_channel = 0;
  std::span<const FittedChannel> channels;

  [[nodiscard]] double period_s() const noexcept { return kTwoPi / omega; }
  [[nodiscard]] const FittedChannel& channel(int c) const noexcept { return channels[static_cast<std::size_t>(c)]; }
};

// The drive's frequency as estimated apart from the fit of the natural oscillations.
struct SeenFrequency {
  double omega = 1.0;         // at about_ns, rad/s
  double rate = 0.0;          // drift of omega, rad/s²
  std::int64_t about_ns = 0;  // the middle of the data used
  double u = INFINITY;        // standard uncertainty of omega, rad/s

  // ω at t, rad/s.
  [[nodiscard]] double at(std::int64_t t_ns) const { return omega + rate * to_s(t_ns - about_ns); }
};

}  // namespace dwell
