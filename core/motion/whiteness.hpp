// Are innovations noise? The test of Ljung and Box (1978) over ten lags.
#pragma once

#include <limits>
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

struct Whiteness {
  double ljung_box = std::numeric_limits<double>::quiet_NaN();  // N (N+2) Σ ρ_l² / (N - l); NaN: fewer than 50
  double p =
      std::numeric_limits<double>::quiet_NaN();  // chance that white ones give as much: χ², 10 degrees of freedom
  double squares = 0.0;  // N Σ ρ_l²: the squares of e/√S that the correlated part amounts to
};
[[nodiscard]] Whiteness whiteness_of(const std::vector<MotionInnovation>& innovations);

}  // namespace dwell
