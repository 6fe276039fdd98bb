// Members of JSON that may hold anything: one that is missing or of another type is as one that is not there. Heavy:
// include it in .cpp only. Thread-safe; allocates.
#pragma once

#include <cstddef>
#include <string>

#include "core/result/dwell.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {

// null: it is not there.
[[nodiscard]] inline const Json* member_of(const Json& object, const char* name) {
  const auto it = object.is_object() ? object.find(name) : object.end();
  return it != object.end() ? &*it : nullptr;
}

// Empty: it is not there.
[[nodiscard]] inline std::string text_member(const Json& object, const char* name) {
  const Json* const value = member_of(object, name);
  return value != nullptr && value->is_string() ? value->get<std::string>() : "";
}

// NaN: it is not there.
[[nodiscard]] inline double number_member(const Json& object, const char* name) {
  const Json* const value = member_of(object, name);
  return value != nullptr && value->is_number() ? value->get<double>() : kNaN;
}

// 0: it is not there, or negative.
[[nodiscard]] inline std::size_t count_member(const Json& object, const char* name) {
  const Json* const value = member_of(object, name);
  return value != nullptr && value->is_number_integer() && *value >= 0 ? value->get<std::size_t>() : 0;
}

// An integer as people see it; "—": it is not there.
[[nodiscard]] inline std::string integer_text(const Json& object, const char* name) {
  const Json* const value = member_of(object, name);
  return value != nullptr && value->is_number_integer() ? value->dump() : kNoNumber;
}

}  // namespace dwell::ctl
