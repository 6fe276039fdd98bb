// Numbers for people.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

namespace dwell::driver {

// "0.5 s"
[[nodiscard]] inline std::string seconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", static_cast<double>(ns) * 1e-9);
  return text;
}

}  // namespace dwell::driver
