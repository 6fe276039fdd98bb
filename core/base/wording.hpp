// Numbers and lists as core's messages show them. Allocates; off the sample path.
#pragma once

#include <string>
#include <vector>

namespace dwell {

// `digits` significant digits, without an exponent from 1e-3 to below 1e6: "16.6", "0.25", "1.2e+07".
[[nodiscard]] std::string brief(double value, int digits = 3);

// "2.5 %", of a part of one; two digits.
[[nodiscard]] std::string percent(double part);

// "-11400 ± 250 N/m": U to two significant digits, the value to match. U not finite: "—" for it.
[[nodiscard]] std::string plus_minus(double value, double U, const std::string& unit);

// A unit of the rig file as tables show it: "N·m" of "N*m".
[[nodiscard]] std::string unit_text(const std::string& unit);

// "y1", "y1 and y2", "y1, y2 and reaction"
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

// "element 1", "elements 1 and 3"; no ks: "no element".
[[nodiscard]] std::string elements_text(const std::vector<int>& ks);

}  // namespace dwell
