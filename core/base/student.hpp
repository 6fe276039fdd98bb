// Quantiles of Student's t for coverage intervals (GUM G.3).
#pragma once

namespace dwell {

// Half width of the two-sided 95 % interval of a normal distribution, in standard deviations.
inline constexpr double kNormal95 = 1.959963984540054;

// The t for which 95 % of Student's distribution lies within ±t. dof: degrees of freedom, not necessarily whole; a dof
// below 1 counts as 1, infinity gives kNormal95. Relative error below 1e-9. Thread-safe.
[[nodiscard]] double student_t95(double dof) noexcept;

}  // namespace dwell
