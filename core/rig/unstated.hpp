// Which uncertainties a rig file leaves out: they count as 0, so that no ± covers them.
#pragma once

#include <string>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

// At most one entry of each kind: "mass 1" or "masses 1 and 3", "scale of y1" or "scales of y0 and y1" or "scales of
// all channels", "delay of …", "low-pass of …", "high-pass of …". A delay is stated by its channel or by its device.
// Auxiliary channels are none. Allocates, thread-safe.
[[nodiscard]] std::vector<std::string> unstated_uncertainties(const Rig& rig);

}  // namespace dwell
