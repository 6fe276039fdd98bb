// A number written with a decimal comma, which TOML does not know: what a syntax error there is most likely about.
#pragma once

#include <toml++/toml.h>

#include <optional>
#include <string>
#include <string_view>

namespace dwell::config {

// The value of `key = 0,01` in that line (from 1) of the text, with a decimal point, or the first such element of
// `key = [0,01, 1]`; none: there is no such value.
[[nodiscard]] std::optional<std::string> decimal_comma(std::string_view text, int line);

// An array whose length does not fit: "; expected a decimal point: 0.5" where two integers of it stand in the file
// without a space between, as in [0,5, 1]; else empty.
[[nodiscard]] std::string decimal_comma_hint(const toml::array& numbers);

}  // namespace dwell::config
