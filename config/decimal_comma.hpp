// A number written with a decimal comma, which TOML does not know: what a syntax error there is most likely about.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace dwell::config {

// The value of `key = 0,01` in that line (from 1) of the text, with a decimal point; none: there is no such value.
[[nodiscard]] std::optional<std::string> decimal_comma(std::string_view text, int line);

}  // namespace dwell::config
