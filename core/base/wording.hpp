// Numbers and lists as core's messages show them. Allocates; off the sample path.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace dwell {

inline constexpr std::size_t kNamedAtMost = 4;  // coefficients or channels in one message

// `digits` significant digits: "16.6", "0.25", "1.2e+07". No exponent from 1e-3 to below 1e6; "—" if not finite.
[[nodiscard]] std::string brief(double value, int digits = 3);

// 0.025 gives "2.5 %"; two significant digits.
[[nodiscard]] std::string percent(double part);

// "-11400 ± 250 N/m": U has two significant digits, the value ends at the same digit. A U that is not finite or not
// above 0 is shown as "—".
[[nodiscard]] std::string plus_minus(double value, double U, const std::string& unit);

// A unit of the rig file as tables show it: "N*m" gives "N·m".
[[nodiscard]] std::string unit_text(const std::string& unit);

// "y1", "y1 and y2", "y1, y2 and reaction"
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

// "element 1", "elements 1 and 3"; an empty ks gives "no element".
[[nodiscard]] std::string elements_text(const std::vector<int>& ks);

}  // namespace dwell
