// Quantiles of Student's t for coverage intervals (GUM G.3).
#pragma once

namespace dwell {

// Standard deviations that hold 95 % of a normal distribution, two-sided.
inline constexpr double kNormal95 = 1.959963984540054;

// The factor t for which a fraction 0.95 of Student's distribution with `dof` >= 1 (not necessarily whole) degrees of
// freedom lies within ±t; infinity gives 1.95996. dof below 1 is taken as 1. Relative error below 1e-9. Thread-safe.
[[nodiscard]] double student_t95(double dof) noexcept;

}  // namespace dwell
