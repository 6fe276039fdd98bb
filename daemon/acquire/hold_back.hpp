// How long the merger must wait for the slowest device of a rig.
#pragma once

#include <cstdint>

#include "config/rig_file.hpp"

namespace dwell {

// ns, 0.1 s … 10 s. The greatest age at which a reading of any device may reach the host by what its driver says of
// itself, and a stall of the host's threads. A shorter time would drop readings as late that came when they had to.
[[nodiscard]] std::int64_t hold_back_ns(const config::RigFile& file);

}  // namespace dwell
