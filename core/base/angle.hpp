#pragma once

#include <numbers>

namespace dwell {

inline constexpr double kTwoPi = 2 * std::numbers::pi;  // rad: one turn, ω = kTwoPi f

}  // namespace dwell
