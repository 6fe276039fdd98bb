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

// Records of a block at most: bounds what a hostile file can make a reader allocate (about 200 MB). The worst block is
// then 35 MB, which ChainReader::kMaxBody allows. 64 channels at 10 kHz fill it in 1.6 s.
inline constexpr std::size_t kMaxBlockRecords = 1u << 20;

// records: at most kMaxBlockRecords. Takes about 0.03 µs and 66 bytes of memory for each. Throws std::bad_alloc.
[[nodiscard]] std::string encode_block(std::span<const Record> records);

// Replaces `out`. Fails with the first thing that is wrong, then `out` is empty. Whatever the bytes, it allocates no
// more than kMaxBlockRecords records need. Takes about 0.02 µs for each.
[[nodiscard]] Result<void> decode_block(std::string_view bytes, std::vector<Record>& out);

}  // namespace dwell::record
