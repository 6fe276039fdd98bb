// A dwell in the report.
#pragma once

#include <string>

#include "daemon/report/dwell_view.hpp"

namespace dwell::handon {

// Coefficients with their budget, verdicts, phasors with their picture: whole HTML.
[[nodiscard]] std::string report_dwell(const DwellView& view);

}  // namespace dwell::handon
