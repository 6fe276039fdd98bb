// Numbers in the forms that files for other programs ask for.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace dwell::handon {

// What printf() makes of the pattern and the values; at most 399 bytes of it.
template <class... Values>
[[nodiscard]] std::string format(const char* pattern, Values... values) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace dwell::handon
