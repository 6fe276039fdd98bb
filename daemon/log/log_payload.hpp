// A line and its fields as the one string that spdlog carries: message, then \x1f KEY=value for each field. Controls in
// message and values become blanks.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "daemon/log/log.hpp"

namespace dwell {

inline constexpr char kFieldMark = '\x1f';

[[nodiscard]] std::string make_payload(std::string_view message, std::initializer_list<LogField> fields);

// The message alone.
[[nodiscard]] inline std::string_view message_of(std::string_view payload) noexcept {
  return payload.substr(0, payload.find(kFieldMark));
}

}  // namespace dwell
