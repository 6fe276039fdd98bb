// A `result` entry as text: what can be said of it without building its JSON document, which takes ten times as long.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/record/keys.hpp"

namespace dwell::record {

struct ResultFront {
  std::uint64_t position = 0;
  bool final = false;
  std::string_view dwell;  // a part of the body: what may be a JSON object
};
// Of a body in the form that the recorder writes; nullopt: another form.
[[nodiscard]] std::optional<ResultFront> front_of(std::string_view body) noexcept;

// true: `text` is one JSON object that the parser takes, not nested deeper than 60. false: it may be none, or one with
// escapes or numbers that need a closer look. Cost: 2 ns a byte.
[[nodiscard]] bool is_plain_object(std::string_view text) noexcept;

// That parse_result() takes the body; fails as that does.
[[nodiscard]] Result<void> check_result(const std::string& body);

}  // namespace dwell::record
