// Are innovations noise? The test of Ljung and Box (1978) over ten lags.
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Innovations less white than this by chance: their information overstates what the readings tell.
inline constexpr double kNotWhite = 1e-3;
// Residuals as correlated as this by chance, once in a million: the model is contradicted, by friction or a spring that
// nobody stated. No widening can tell how wrong the coefficients are.
inline constexpr double kContradicted = 1e-6;

// Residuals below this part of the channel's motion are the rounding of numbers and contradict nothing.
inline constexpr double kDigits = 1e-6;

inline constexpr int kWhitenessLags = 10;

// N (N+2) Σ ρ_l² / (N - l): χ² with kWhitenessLags degrees of freedom where they are white. NaN: fewer than 50.
[[nodiscard]] double ljung_box(const std::vector<MotionInnovation>& innovations);
// Chance that white ones give as much.
[[nodiscard]] double whiteness_p(double ljung_box);

}  // namespace dwell
