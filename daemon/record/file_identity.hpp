// By what a change of a run's file is noticed: size and modification time of it and of the -wal beside it.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace dwell::record {

// Zeros: neither file is there.
using FileIdentity = std::array<std::int64_t, 6>;

// Two system calls. Thread-safe.
[[nodiscard]] FileIdentity identity_of(const std::string& path);

}  // namespace dwell::record
