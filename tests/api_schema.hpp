// Holds JSON against docs/api.schema.json: the part of JSON Schema (draft 2020-12) that it uses, and no more. A keyword
// that is not known here is a fault of the schema.
#pragma once

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace dwell::test {

class ApiSchema {
 public:
  using Json = nlohmann::json;

  ApiSchema() : document_(Json::parse(std::ifstream(DWELL_API_SCHEMA))) {}

  // What is wrong with `value` as a NAME of $defs, with its place; empty: nothing.
  [[nodiscard]] std::string faults(const std::string& name, const Json& value) const {
    return check(definition(name), value, name);
  }
  // The same of a text, which must be JSON.
  [[nodiscard]] std::string faults_of_text(const std::string& name, const std::string& text) const {
    const Json value = Json::parse(text, nullptr, false);
    return value.is_discarded() ? name + ": no JSON" : faults(name, value);
  }

  // What is not documented: a member without a description, a number without a unit, a keyword that is not known.
  [[nodiscard]] std::string undocumented() const {
    std::string all;
    for (const auto& [name, schema] : document_["$defs"].items()) all += undocumented(schema, name);
    return all;
  }

 private:
  [[nodiscard]] const Json& definition(const std::string& name) const { return document_["$defs"].at(name); }

  static bool has_type(const Json& value, const std::string& type) {
    if (type == "null") return value.is_null();
    if (type == "boolean") return value.is_boolean();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "string") return value.is_string();
    if (type == "array") return value.is_array();
    return type == "object" && value.is_object();
  }
  static Json listed(const Json& type) { return type.is_array() ? type : Json::array({type}); }
  static bool is_number(const Json& schema) {
    if (!schema.contains("type")) return false;
    const Json types = listed(schema["type"]);
    return std::any_of(types.begin(), types.end(), [](const Json& t) { return t == "number" || t == "integer"; });
  }

  [[nodiscard]] std::string check(const Json& schema, const Json& value, const std::string& at) const {
    std::string all;
    const auto wrong = [&](const std::string& what) { all += at + ": " + what + ", found " + value.dump() + "\n"; };
    if (schema.contains("$ref")) all += check(definition(schema["$ref"].get<std::string>().substr(8)), value, at);
    if (schema.contains("type")) {
      const Json types = listed(schema["type"]);
      if (std::none_of(types.begin(), types.end(), [&](const Json& type) { return has_type(value, type); }))
        wrong("expected " + types.dump());
    }
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
      wrong("expected one of " + schema["enum"].dump());
    if (schema.contains("const") && value != schema["const"]) wrong("expected " + schema["const"].dump());
    if (schema.contains("minimum") && value.is_number() && value < schema["minimum"])
      wrong("expected at least " + schema["minimum"].dump());
    if (schema.contains("anyOf") && std::none_of(schema["anyOf"].begin(), schema["anyOf"].end(),
                                                 [&](const Json& one) { return check(one, value, at).empty(); }))
      all += at + ": fits none of its forms; as the first: " + check(schema["anyOf"][0], value, at);
    if (schema.contains("items") && value.is_array())
      for (std::size_t i = 0; i < value.size(); ++i)
        all += check(schema["items"], value[i], at + "[" + std::to_string(i) + "]");
    if (schema.contains("properties") && value.is_object()) all += check_members(schema, value, at);
    return all;
  }

  [[nodiscard]] std::string check_members(const Json& schema, const Json& value, const std::string& at) const {
    std::string all;
    for (const Json& name : schema["required"])
      if (!value.contains(name)) all += at + ": has no " + name.dump() + "\n";
    for (const auto& [name, member] : value.items()) {
      if (schema["properties"].contains(name)) {
        all += check(schema["properties"][name], member, at + "." + name);
      } else if (schema["additionalProperties"].is_object()) {
        all += check(schema["additionalProperties"], member, at + "." + name);
      } else {
        all += at + ": \"" + name + "\" is not documented\n";
      }
    }
    return all;
  }

  [[nodiscard]] std::string undocumented(const Json& schema, const std::string& at) const {
    static const Json known = {"$ref",  "anyOf",    "type",   "enum",       "const",       "minimum",
                               "items", "required", "x-unit", "properties", "description", "additionalProperties"};
    std::string all;
    for (const auto& [keyword, value] : schema.items())
      if (std::find(known.begin(), known.end(), keyword) == known.end())
        all += at + ": unknown keyword " + keyword + "\n";
    if (!schema.contains("$ref") && schema.value("description", "").empty()) all += at + ": no description\n";
    if (is_number(schema) && schema.value("x-unit", "").empty()) all += at + ": no unit\n";
    if (schema.contains("properties") && (!schema.contains("required") || !schema.contains("additionalProperties")))
      all += at + ": required and additionalProperties are not said\n";
    if (schema.contains("properties"))
      for (const auto& [name, member] : schema["properties"].items()) {
        all += undocumented(member, at + "." + name);
        if (member.value("description", "").empty()) all += at + "." + name + ": no description\n";
      }
    if (schema.contains("items")) all += undocumented(schema["items"], at + "[]");
    if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object())
      all += undocumented(schema["additionalProperties"], at + ".*");
    return all;
  }

  Json document_;
};

}  // namespace dwell::test
