// Members of a JSON object read as what they must be; one that is missing or of another type throws a Mistake that
// names it. For the parsers of this folder. Heavy: include it in .cpp only.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::json_reader {

// Thrown and caught within one file of this folder: a parser of nested fields is clearest with it.
struct Mistake : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] inline void fail(const std::string& field, const char* expected) {
  throw Mistake(field + ": expected " + expected);
}

inline const Json& member(const Json& object, const char* name) {
  if (!object.is_object()) fail(name, "to stand in an object");
  const auto it = object.find(name);
  if (it == object.end()) fail(name, "to be there");
  return *it;
}

inline double real(const Json& value, const char* name) {
  if (value.is_null()) return kNaN;
  if (!value.is_number()) fail(name, "a number or null");
  return value.get<double>();
}
inline double real_of(const Json& object, const char* name) { return real(member(object, name), name); }

inline std::string string_of(const Json& object, const char* name) {
  const Json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_string()) fail(name, "a string or null");
  return value.get<std::string>();
}

inline bool boolean_of(const Json& object, const char* name) {
  const Json& value = member(object, name);
  if (!value.is_boolean()) fail(name, "true or false");
  return value.get<bool>();
}

inline int integer(const Json& value, const char* name) {
  if (!value.is_number_integer()) fail(name, "an integer");
  const auto wide = value.get<std::int64_t>();
  if (wide < 0 || wide > 1'000'000'000) fail(name, "an integer from 0 to 1e9");
  return static_cast<int>(wide);
}

inline std::uint64_t natural_of(const Json& object, const char* name) {
  const Json& value = member(object, name);
  if (!value.is_number_unsigned()) fail(name, "an integer, 0 or more");
  return value.get<std::uint64_t>();
}

inline const Json& array_of(const Json& object, const char* name) {
  const Json& value = member(object, name);
  if (!value.is_array()) fail(name, "an array");
  return value;
}

inline std::vector<std::string> strings_of(const Json& object, const char* name) {
  std::vector<std::string> strings;
  for (const Json& value : array_of(object, name)) {
    if (!value.is_string()) fail(name, "strings");
    strings.push_back(value.get<std::string>());
  }
  return strings;
}

template <typename Enum>
Enum named(const std::string& word, const char* field, Enum last) {
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (word == to_string(static_cast<Enum>(i))) return static_cast<Enum>(i);
  }
  fail(field, "one of the words of the interface");
}

}  // namespace dwell::json_reader
