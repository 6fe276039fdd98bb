// Finds errors of a channel's readings that grow with its motion.
//
// Noise is as large where a reading turns as where it crosses zero. A reading that was taken at a wrong time is off
// most at the zero crossings. A reading with a wrong gain is off most at the turning points. Only errors that differ
// from reading to reading are found; a constant or slowly changing one is not. Such errors usually have a mean. The
// mean shifts the phasor, however many readings there are.
//
// r_i is the residual of the harmonic fit, less its own harmonics up to the eighth. The reading is |X| sin ψ. A cubic
// through two neighbours on each side predicts r_i. What it misses is s_i, a sum of five residuals with weights w_k:
//
//   s_i = r_i - prediction = Σ w_k r_{i+k},    evenly spaced: w = 1/6, -2/3, 1, -2/3, 1/6
//   x_i = -(s_i² - mean s²) cos 2ψ_i
//
// A drive that hunts, the rest of a transient and slow hum are smooth, so they leave next to nothing in s. Errors of
// variance m (1 - cos 2ψ) (gain) or m (1 + cos 2ψ) (time) give
//
//   mean x = ± m κ/2,    κ = mean of Σ w_k² cos 2(ψ_{i+k} - ψ_i)
//
// The x of neighbours are correlated. The variance of their sum is 2.6 Σ x² for Gaussian noise, and 2.7 Σ x² for single
// spikes, (Σ w²)² / Σ w⁴.
//
// Source: the test of heteroscedasticity by Breusch and Pagan (Econometrica 47 (1979) 1287), with the variance that
// Koenker gives it (J. of Econometrics 17 (1981) 107), which takes no distribution for granted.
#pragma once

#include <cstdint>
#include <span>

#include "core/fit/harmonic_fit.hpp"

namespace dwell {

// Standard deviations of the two kinds of errors; at most one is above 0.
struct MovingErrors {
  double instants_s = 0.0;   // of the instants, s
  double instants_u2 = 0.0;  // standard uncertainty of the square of instants_s, s²
  double part = 0.0;         // of the gain: relative
};

// Standard uncertainties from such errors; they stand for the unknown mean.
struct UnevenReadings {
  double part = 0.0;      // of the gain: relative
  double own_s = 0.0;     // of this channel's instants
  double shared_s = 0.0;  // of instants that a group of channels has in common; the same number for all of these
  int with = -1;          // the channel that names the group; -1: no group
};

// A reading, and what moving_errors() computes from it.
struct MovingReading {
  std::int64_t t_ns = 0;
  double value = 0.0;  // SI
  double residual = 0.0;
  double sine = 0.0, cosine = 0.0;  // of ψ
  double sharpness = 0.0;           // s; NaN: neighbours are missing
  double kept = 0.0, kappa = 0.0;   // Σ w², and κ of this reading
};

struct MovingContext {
  HarmonicFit fit;  // phases about t_ref_ns
  std::int64_t t_ref_ns = 0;
  double omega = 0.0;       // rad/s
  double interval_s = 0.0;  // between two of the readings given, as a rule
  double rounding = 0.0;    // step of the readings, SI; 0: none is known
};

// readings: of one channel in steady motion, by time; fills all but t_ns and value. Zeros where nothing is found, where
// there are too few readings, or fewer than sixteen in a period. About 100 ns a reading; real-time safe; thread-safe.
[[nodiscard]] MovingErrors moving_errors(std::span<MovingReading> readings, const MovingContext& context) noexcept;

// A channel as moving_errors() has seen it.
struct MovingChannel {
  std::span<const MovingReading> readings;
  double amplitude = 0.0;  // of them, SI
  double known_s = 0.0;    // standard deviation of the instants that the budget has already
  MovingErrors errors;
};

// Whether the errors of two channels' instants are the same: those of a scan that has one stamp. True if the errors are
// correlated, and the correlated part is all that either channel shows. One of them may be too noisy to show errors by
// itself. omega: rad/s. O(readings); real-time safe; thread-safe.
[[nodiscard]] bool share_instants(const MovingChannel& a, const MovingChannel& b, double omega) noexcept;

}  // namespace dwell
