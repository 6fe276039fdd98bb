// A stretch of the ordered stream as compressed bytes: the body of a `stream` entry. Every record comes back bit for
// bit and in its place. docs/run-file.md, "Blocks".
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/record/result.hpp"

namespace dwell::record {

// Most records of a block. Bounds the memory that a hostile file can make a reader allocate to about 200 MB. The worst
// block then has 35 MB, which ChainReader::kMaxBody allows. 64 channels at 10 kHz fill a block in 1.6 s.
inline constexpr std::size_t kMaxBlockRecords = 1u << 20;

inline constexpr std::size_t kPlanes = 33;  // of a block: one for each byte of a record, one for the form of its value

// records: at most kMaxBlockRecords. Takes about 0.03 µs and 66 bytes of memory for each. Throws std::bad_alloc.
[[nodiscard]] std::string encode_block(std::span<const Record> records);

// Replaces `out`. Fails with the first mistake; then `out` is empty. Never allocates more than kMaxBlockRecords records
// need. Takes about 0.02 µs for each.
[[nodiscard]] Result<void> decode_block(std::string_view bytes, std::vector<Record>& out);

}  // namespace dwell::record
