// Where sampling folds the harmonics of the drive.
//
// Sampled at `rate`, harmonic m of a drive at f reads exactly as harmonic h where m f ± h f is a whole multiple of the
// rate. A rate that is a whole multiple of f therefore puts harmonics beyond the fitted ones onto the fitted ones, and
// no fit can tell them apart. A rate a little beside it leaves them `apart` from each other: data of several times
// 1/apart tell them apart.
//
// Pure; safe from any thread; microseconds, off the sample path.
#pragma once

#include <limits>

namespace dwell {

// The highest harmonic that is looked at: measuring practice ends there as well (IEC 61000-4-7, harmonics to the 50th).
// Halved: harmonics of a stick-slip drive at 26 … 50 f go unseen. Doubled: rates near 100 f are moved for nothing.
inline constexpr int kFoldedOrder = 50;

// The largest part of the rate by which polling may be shifted.
inline constexpr double kRateShift = 0.01;

// A folded harmonic counts by m · apart: friction, the sharpest common nonlinearity, makes a square wave of force,
// whose harmonics fall as 1/m. Above 1 f it is clear: harmonic 4 lies a quarter of f beside, which 4 periods resolve.
inline constexpr double kClearOfHarmonics = 1.0;

// The folded harmonic that does most harm: of least m · apart, of several the lowest.
struct Folding {
  int harmonic = 0;  // beyond the fitted ones, up to kFoldedOrder; 0: none folds
  int onto = 0;      // 0 (the mean) … fitted
  double apart_hz = std::numeric_limits<double>::infinity();  // from it, as read

  // m · apart; 0: it cannot be told from harmonic `onto` by any length of data.
  [[nodiscard]] double distance_hz() const noexcept { return harmonic > 0 ? harmonic * apart_hz : apart_hz; }
};

// rate_hz, drive_hz > 0; fitted: harmonics in the fit, H. O(kFoldedOrder).
[[nodiscard]] Folding worst_folding(double rate_hz, double drive_hz, int fitted) noexcept;

// The rate at most kRateShift beside rate_hz at which the worst folding is least bad; of equally good ones the nearest
// to rate_hz. rate_hz itself where that is clear already, or below 2 (H + 1) f; never below that otherwise.
[[nodiscard]] double rate_beside_foldings(double rate_hz, double drive_hz, int fitted) noexcept;

}  // namespace dwell
