// SHA-256 of a file that may be larger than the memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Of the file's bytes, 64 hexadecimal digits; read in pieces of 64 KiB. nullopt: it has more than `most` bytes; then at
// most `most` and one piece were read. Fails with "PATH: reason". Any thread; waits for the disk. Cost: 0.5 … 4 s a GB,
// by the processor, where the disk does not take longer.
[[nodiscard]] Result<std::optional<std::string>> file_sha256(const std::string& path, std::uintmax_t most);

}  // namespace dwell::record
