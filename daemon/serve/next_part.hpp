// Takes a query or a header field apart at a separator. Pure, thread-safe.
#pragma once

#include <algorithm>
#include <string_view>

namespace dwell {

// The part of `rest` before the first separator, or all of it. `rest` becomes what stands behind the separator.
inline std::string_view next_part(std::string_view& rest, char separator) noexcept {
  const std::string_view part = rest.substr(0, rest.find(separator));
  rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  return part;
}

}  // namespace dwell
