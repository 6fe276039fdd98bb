// Are innovations noise? The test of Ljung and Box (1978) over ten lags.
#pragma once

#include <limits>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// A p below this: not white. The information then overstates what the readings tell.
inline constexpr double kNotWhite = 1e-3;
// A p below this contradicts the model: it lacks, say, friction or a spring. No widening of u can tell how wrong the
// coefficients are.
inline constexpr double kContradicted = 1e-6;

// Residuals below this part of the channel's motion are the rounding of numbers and contradict nothing.
inline constexpr double kDigits = 1e-6;

inline constexpr int kWhitenessLags = 10;

struct Whiteness {
  double ljung_box = std::numeric_limits<double>::quiet_NaN();  // N (N+2) Σ ρ_l² / (N - l); NaN: fewer than 50
  double p =
      std::numeric_limits<double>::quiet_NaN();  // chance that white ones give as much: χ², 10 degrees of freedom
  double squares = 0.0;                          // N Σ ρ_l²: the part of Σ e²/S that the lags explain
  double largest = 0.0;                          // of |ρ_l|
};
[[nodiscard]] Whiteness whiteness_of(const std::vector<MotionInnovation>& innovations);

}  // namespace dwell
