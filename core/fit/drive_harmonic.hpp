// Tells a line at one of the drive's harmonics that are not fitted.
#pragma once

#include <cmath>

namespace dwell {

// m if the line lies at m times the drive's frequency within `within`, m beyond the fitted harmonics; else 0. omega: of
// the line; drive: of the drive, > 0; within: rad/s. A line anywhere lies there by chance with 2 within/drive: 0 where
// that is above a twentieth. Thread-safe, no allocation.
[[nodiscard]] inline int unfitted_harmonic(double omega, double drive, double within, int fitted) noexcept {
  const double times = std::round(omega / drive);
  if (!(times > fitted) || !(40 * within < drive)) return 0;
  return std::abs(omega - times * drive) <= within ? static_cast<int>(times) : 0;
}

}  // namespace dwell
