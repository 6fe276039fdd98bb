// Finds where sampling folds the drive's harmonics, and a rate nearby that folds them where they do little harm.
//
// Sampled at `rate`, harmonic m of a drive at f reads exactly as harmonic h if m f ± h f is a whole multiple of the
// rate. So a rate that is a whole multiple of f folds higher harmonics onto fitted ones, and no fit can separate them.
// A rate slightly beside keeps a distance `apart` between them: data several times longer than 1/apart separate them.
//
// Pure, thread-safe. Takes microseconds: not for the sample path.
#pragma once

#include <limits>

namespace dwell {

// Highest harmonic considered; measuring practice ends there too (IEC 61000-4-7, harmonics to the 50th). Halved:
// harmonics of a stick-slip drive at 26 … 50 f go unseen. Doubled: rates near 100 f are shifted for nothing.
inline constexpr int kFoldedOrder = 50;

// Largest relative shift of the polling rate.
inline constexpr double kRateShift = 0.01;

// Limit of m · apart, in parts of f, above which a folding is harmless. Friction, the sharpest common nonlinearity,
// makes a square wave of force. Its harmonics fall as 1/m, hence the factor m. At the limit harmonic 4 lies f/4 beside,
// which 4 periods resolve.
inline constexpr double kClearOfHarmonics = 1.0;

// The most harmful folding: that with the least m · apart; of equal ones the lowest harmonic.
struct Folding {
  int harmonic = 0;  // m, beyond the fitted ones, up to kFoldedOrder; 0: none folds
  int onto = 0;      // the fitted harmonic next to its alias, 0 (the mean) … fitted
  double apart_hz = std::numeric_limits<double>::infinity();  // from the alias to `onto`

  // m · apart; 0: no length of data separates it from harmonic `onto`. Infinity: none folds.
  [[nodiscard]] double distance_hz() const noexcept { return harmonic > 0 ? harmonic * apart_hz : apart_hz; }
};

// rate_hz, drive_hz > 0; fitted: harmonics in the fit, H. O(kFoldedOrder).
[[nodiscard]] Folding worst_folding(double rate_hz, double drive_hz, int fitted) noexcept;

// The rate within ± kRateShift of rate_hz whose worst folding does least harm; of equal ones the nearest. rate_hz
// itself if its foldings are harmless or it is below 2 (H + 1) f. Otherwise never below 2 (H + 1) f.
[[nodiscard]] double rate_beside_foldings(double rate_hz, double drive_hz, int fitted) noexcept;

}  // namespace dwell
