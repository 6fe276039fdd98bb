#pragma once

namespace dwell {

// A result below this part of its largest term is the rounding of double precision (2e-16, times some thousand sums).
// Doubled or halved, nothing changes: real differences are far larger.
inline constexpr double kOnlyRounding = 1e-9;

}  // namespace dwell
