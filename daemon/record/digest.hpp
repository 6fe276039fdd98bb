// SHA-256 digests, and the head of a chain of entries.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace dwell::record {

using Digest = std::array<std::uint8_t, 32>;

// One entry of a run file or of the ledger. docs/run-file.md, "Kinds of entries".
struct Entry {
  std::int64_t seq = 0;   // 1, 2, 3 … without a gap
  std::string kind;       // ASCII
  std::int64_t t_ns = 0;  // run file: CLOCK_MONOTONIC_RAW, covered up to here; ledger: UTC since 1970
  std::string body;       // JSON, or the bytes of a block
};

// The head after `entry`, where `before` is the head before it (all zero before the first). docs/run-file.md, "The
// chain".
[[nodiscard]] Digest next_head(const Digest& before, const Entry& entry);

// The hash of a note, as the next note states it. docs/run-file.md, "The notes".
[[nodiscard]] Digest note_hash(std::string_view note);

// 64 hexadecimal digits; standard base64 with padding.
[[nodiscard]] std::string hex(const Digest& digest);
[[nodiscard]] std::string base64(std::string_view bytes);
// The inverse. nullopt: not a text that hex() or base64() writes.
[[nodiscard]] std::optional<Digest> from_hex(std::string_view text);
[[nodiscard]] std::optional<std::string> from_base64(std::string_view text);

}  // namespace dwell::record
