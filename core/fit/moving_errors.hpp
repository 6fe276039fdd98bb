// Finds errors of a channel's readings that grow with its motion.
//
// Noise is as large where a reading turns as where it crosses zero. An instant that is off by τ puts a reading off by
// τ times its slope: most at the zero crossings. A reading that is too small by a part of itself is off most at the
// turning points. Both are random from reading to reading here: stamps that scatter, readings that a gateway repeats or
// takes late, values that are at times on another scale. Such errors seldom have the mean zero, and their mean shifts
// the phasor, however many readings there are.
//
// With r the residual of the harmonic fit, at ψ the phase of the reading |X| sin ψ:
//
//   curvature  c_i = r_i - (its neighbours' r, interpolated),   e_i = c_j - c_i,  j the reading one period later
//   x_i = -(e_i² - mean e²) cos 2ψ_i
//
// The curvature leaves nothing of what is smooth over three readings (a drive that hunts, hum, a transient's rest); the
// difference over a period nothing of what repeats with the motion (harmonics that are not fitted). White errors keep
// three times their variance. With m the mean square of errors that go with sin ψ (+) or cos ψ (-), mean x = ± 3m/2.
// Curvatures overlap, and so do differences: the variance of the sum of x is at most 4 Σ x², reached by single spikes.
#pragma once

#include <complex>
#include <cstdint>
#include <span>

#include "core/fit/harmonic_fit.hpp"

namespace dwell {

// Standard deviations of the two kinds of errors; at most one is above 0.
struct MovingErrors {
  double instants_s = 0.0;   // of the instants, s
  double instants_u2 = 0.0;  // standard uncertainty of the square of instants_s, s²
  double part = 0.0;         // of a reading, as a part of itself
};

// Standard uncertainties of a channel by such errors, whose mean is not known.
struct UnevenReadings {
  double part = 0.0;      // of the scale, as a part
  double own_s = 0.0;     // of this channel's instants
  double shared_s = 0.0;  // of instants that it shares with other channels, the same number for all of these
  int with = -1;          // the lowest of these; -1: none
};

// A reading, and what is computed from it.
struct MovingReading {
  std::int64_t t_ns = 0;
  double value = 0.0;  // SI
  double residual = 0.0, curvature = 0.0;
  double sine = 0.0, cosine = 0.0;  // of ψ
  double change = 0.0;              // e; NaN: none
};

// What is known of a channel's fit, and of errors that its budget has already.
struct MovingContext {
  HarmonicFit fit;  // phases about t_ref_ns
  std::int64_t t_ref_ns = 0;
  double omega = 0.0;             // rad/s
  double known_instants_s = 0.0;  // standard deviation of the instants that the budget has
  double rounding = 0.0;          // step of the readings, SI; 0: none is known
};

// readings: of one channel in steady motion, by time; fills all but t_ns and value. Nothing (zeros) where there are too
// few of them, or fewer than twelve in a period. O(readings · H); real-time safe; thread-safe.
[[nodiscard]] MovingErrors moving_errors(std::span<MovingReading> readings, const MovingContext& context) noexcept;

// A channel as moving_errors() has seen it.
struct MovingChannel {
  std::span<const MovingReading> readings;
  double amplitude = 0.0;  // of them, SI
  MovingErrors errors;
};

// Whether the errors of two channels' instants are the same: those of a scan that has one stamp. So they are if errors
// in common show, and explain what each channel shows, within the uncertainty. One of them may show nothing by itself.
// omega: rad/s. O(readings).
[[nodiscard]] bool share_instants(const MovingChannel& a, const MovingChannel& b, double omega) noexcept;

}  // namespace dwell
