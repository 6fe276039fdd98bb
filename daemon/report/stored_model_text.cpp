#include "daemon/report/stored_model_text.hpp"

#include <algorithm>

#include "core/base/wording.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/objection_json.hpp"

namespace dwell {
namespace {

// null: there is no such member.
const Json& child_of(const Json& object, const char* name) {
  static const Json none;
  const auto found = object.is_object() ? object.find(name) : object.end();
  return object.is_object() && found != object.end() ? *found : none;
}

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : std::string(); }

std::string stretch_text(const Json& from) {
  const Json &begin = child_of(from, "from_s"), &end = child_of(from, "until_s"),
             &readings = child_of(from, "readings");
  if (!begin.is_number() || !end.is_number() || !readings.is_number_unsigned()) return {};
  return "from " + seconds_text(begin.get<double>(), 2) + " to " + seconds_text(end.get<double>(), 2) + ", " +
         readings.dump() + " readings: ";
}

std::string estimate_text(const Json& from, const Json& result) {
  const Json& elements = child_of(child_of(result, "motion"), "elements");
  std::string against;
  if (const auto objection = objection_in(result); objection && *objection)
    against = "; against dwell " + std::to_string((*objection)->dwell) + ": " + (*objection)->what;
  if (!elements.is_array())
    return stretch_text(from) + "no coefficients: " + text_of(child_of(result, "motion_reason")) + against;
  const auto found = std::count_if(elements.begin(), elements.end(), [](const Json& element) {
    return child_of(element, "identifiable").is_boolean() && child_of(element, "identifiable").get<bool>();
  });
  return stretch_text(from) + std::to_string(found) + " of " + std::to_string(elements.size()) + " elements" + against;
}

std::string verification_line(const Json& result) {
  const Json &dwell = child_of(result, "dwell"), &e_n = child_of(result, "e_n"), &reasons = child_of(result, "reasons");
  std::string text = dwell.is_number_integer() ? "of dwell " + dwell.dump() + ": " : "";
  text += text_of(child_of(result, "verdict"));
  if (e_n.is_number()) text += ", E_n " + brief(e_n.get<double>(), 2);
  if (reasons.is_array() && !reasons.empty()) text += ": " + text_of(reasons.front());
  return text;
}

}  // namespace

std::string stored_model_text(const std::string& kind, const std::string& from, const std::string& result) {
  const Json of = Json::parse(from, nullptr, false), what = Json::parse(result, nullptr, false);
  return kind == "estimate" ? estimate_text(of, what) : verification_line(what);
}

}  // namespace dwell
