// Lists the uncertainties that a rig file leaves out. They count as 0, so no reported ± covers them.
#pragma once

#include <string>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// At most one entry of each kind: "mass 1" or "masses 1 … 3", "scale of y1" or "scales of y0 and y1" or "scales of all
// channels", "delay of …", "low-pass of …", "high-pass of …". A delay counts as stated if the channel or its device
// states it. Auxiliary channels are left out. Allocates, thread-safe.
[[nodiscard]] std::vector<std::string> unstated_uncertainties(const Rig& rig);

}  // namespace dwell
