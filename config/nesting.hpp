// Finds nesting that no rig file needs, before the parser meets it.
//
// The TOML library destroys nested tables recursively and bounds the depth of brackets only, not that of dotted keys:
// one line of "a.a.a.…" overflows the stack. This look ahead costs one pass over the bytes.
#pragma once

#include <optional>
#include <string_view>

#include "config/mistake.hpp"

namespace dwell::config {

inline constexpr int kMaxBrackets = 16;  // [ and { open at a time
inline constexpr int kMaxDots = 8;       // in one key

// Where the text first nests deeper than that; none: nowhere. Quoted text and comments do not count.
[[nodiscard]] std::optional<Position> too_deep(std::string_view text);

}  // namespace dwell::config
