// SHA-256, as it identifies a rig file.
#pragma once

#include <string>
#include <string_view>

namespace dwell::config {

// Of the bytes, 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace dwell::config
