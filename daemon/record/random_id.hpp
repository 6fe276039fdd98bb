// The ids of runs and ledgers.
#pragma once

#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// 32 hexadecimal digits. Fails where the system yields no random numbers. Thread-safe.
[[nodiscard]] Result<std::string> random_id();

}  // namespace dwell::record
