// The end of all devices of a session at once: each may take half a second, together they must not take longer.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "daemon/acquire/device_host.hpp"

namespace dwell {

// Stops every device. One that has not stopped `within` is cut off from everything and left to a thread of its own:
// what its driver hangs in cannot be ended. It is destroyed when the driver returns, if ever. Their names.
[[nodiscard]] std::vector<std::string> stop_together(std::vector<std::shared_ptr<DeviceHost>> devices,
                                                     std::chrono::milliseconds within);

}  // namespace dwell
