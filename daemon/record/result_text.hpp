// Quick checks of a `result` entry on its text alone. Parsing it as JSON takes ten times as long. Thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/record/result.hpp"

namespace dwell::record {

struct ResultFront {
  std::uint64_t position = 0;
  bool final = false;
  std::string_view dwell;  // a part of the body: what may be a JSON object
};
// Of a body in the form that the recorder writes; nullopt: another form.
[[nodiscard]] std::optional<ResultFront> front_of(std::string_view body) noexcept;

// true: parse_result() accepts `text` as an object. false: not known; parse it. An object with white space between its
// members, \u escapes, long numbers or a nesting beyond 60 also gives false. Cost: 2 ns a byte.
[[nodiscard]] bool is_plain_object(std::string_view text) noexcept;

// Succeeds if parse_result() would; otherwise fails with the same message.
[[nodiscard]] Result<void> check_result(const std::string& body);

}  // namespace dwell::record
