// The limits of the rig file for people: which are violated, undecided, kept, and which have no verdict.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <string>
#include <string_view>

#include "daemon/report/dwell_text.hpp"

namespace dwell {

// The name of the section.
inline constexpr std::string_view kLimits = "limits";

// "stiffness of element 2".
[[nodiscard]] std::string limited_text(const JudgedLimit& limit);
// "7.500 to 8.500 kN/m"; of a one-sided limit "at least 7.500 kN/m", "at most 8.500 kN/m".
[[nodiscard]] std::string bounds_text(const JudgedLimit& limit, Motion motion);
// Of a violated one: "stiffness of element 2 is 9.100 ± 0.021 kN/m, outside 7.500 to 8.500 kN/m", or "…, not at most
// 8.500 kN/m".
[[nodiscard]] std::string violation_text(const JudgedLimit& limit, const Dwell& dwell, Motion motion);

// Worst first: a line for each violated and each undecided limit, one for all that are kept, one for each reason that
// there is no verdict. Empty: the rig has no limits, or the dwell has not settled.
[[nodiscard]] Section limit_section(const DwellView& view, const TextOptions& options);

}  // namespace dwell
