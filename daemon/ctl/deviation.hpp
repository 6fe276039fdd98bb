// The change of each coefficient since the settled dwell before, as the service tells it:
//
//   change since dwell 2; moved: by more than chance (one false alarm in 20 dwells)
//   element  stiffness                         damping
//         1  +0.31 ± 0.12 % moved              -0.4 ± 1.9 %
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <string_view>

#include "daemon/report/dwell_view.hpp"
#include "daemon/report/line.hpp"

namespace dwell::ctl {

inline constexpr std::string_view kDeviation = "deviation";

// A line for each element that has coefficients in `view`, in the columns of Trend::section(). before_ago_s: time since
// the end of the dwell before; not finite: not known. Empty: the service tells of no dwell before.
[[nodiscard]] Section deviation_section(const DwellView& view, double before_ago_s, std::size_t columns);

}  // namespace dwell::ctl
