// Parts that several JSON objects of the interface share. Heavy: include it in .cpp only.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "daemon/report/dwell_json_value.hpp"

namespace dwell {

// A number that does not exist is null.
[[nodiscard]] inline Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
// Empty text is null.
[[nodiscard]] inline Json json_text(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }
[[nodiscard]] Json json_element(const ElementEstimate& element, Motion motion, Detail detail);
// A square matrix from its rows.
[[nodiscard]] Json json_square(const std::vector<double>& row_major);

}  // namespace dwell
