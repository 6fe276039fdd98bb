// Text from outside is UTF-8 or refused: run files hold JSON, which cannot hold other bytes. Any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dwell::record {

// Bytes of the UTF-8 character at the beginning of `text`: shortest form, no surrogate. 0: there is none.
[[nodiscard]] std::size_t utf8_character(std::string_view text) noexcept;

[[nodiscard]] bool is_utf8(std::string_view text) noexcept;

// "byte 5 is 0xFC, expected text in UTF-8", bytes counted from 1; empty: `text` is UTF-8.
[[nodiscard]] std::string why_not_utf8(std::string_view text);

}  // namespace dwell::record
