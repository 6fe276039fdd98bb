#pragma once

namespace dwell {

// Relative step of a running median at each reading: it follows a decay of 1 % a reading. Halved, it lags behind a
// transient. Doubled, noise moves it farther.
inline constexpr double kMedianStep = 0.02;

}  // namespace dwell
