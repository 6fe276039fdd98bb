// A stretch of the ordered stream as compressed bytes: the body of a `stream` entry. Every record comes back bit for
// bit and in its place. docs/run-file.md, "Blocks".
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/record/keys.hpp"

namespace dwell::record {

// Records of a block at most: bounds what a hostile file can make a reader allocate.
inline constexpr std::size_t kMaxBlockRecords = 1u << 21;

// Cost: below 0.1 µs a record. Allocates.
[[nodiscard]] std::string encode_block(std::span<const Record> records);

// Replaces `out`. Fails with the first thing that is wrong. Never allocates more than kMaxBlockRecords records,
// whatever the bytes.
[[nodiscard]] Result<void> decode_block(std::string_view bytes, std::vector<Record>& out);

}  // namespace dwell::record
