// Reads a plugin's table. The plugin states the sizes of its structs, for it may be built against an older or a newer
// header of the same version. Members that either header lacks are not read.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <vector>

#include "drivers/dwell_driver.h"

namespace dwell::config {

// Whether a driver may be called that: [a-z0-9_-], 1 to 64 of them. Nothing else ever becomes part of a path.
[[nodiscard]] inline bool is_driver_name(std::string_view name) noexcept {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

// The plugin's keys, in its order. What its header did not know of a key is zero.
[[nodiscard]] inline std::vector<dwell_key> keys_of(const dwell_driver_table& table) {
  std::vector<dwell_key> keys(table.keys == nullptr ? 0 : table.key_count);
  const char* next = reinterpret_cast<const char*>(table.keys);
  for (dwell_key& key : keys) {
    std::memcpy(&key, next, std::min(table.key_size, sizeof key));
    next += table.key_size;
  }
  return keys;
}

// Null: the driver states nothing of its devices.
[[nodiscard]] inline auto describe_of(const dwell_driver_table& table) noexcept {
  constexpr std::size_t kNeeded = offsetof(dwell_driver_table, describe) + sizeof table.describe;
  return table.size < kNeeded ? nullptr : table.describe;
}

}  // namespace dwell::config
