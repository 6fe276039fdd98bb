#include "daemon/report/stored_model_text.hpp"

#include <algorithm>

#include "core/base/wording.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_reader.hpp"
#include "daemon/report/missing_report.hpp"
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

// ", off by 0.15 ± 0.08 % (accuracy 5 %)"; empty: there is no error.
std::string error_text(const Json& accuracy) {
  const Json &asked = child_of(accuracy, "asked"), &seen = child_of(accuracy, "seen"), &U = child_of(accuracy, "U");
  if (!asked.is_number() || !seen.is_number() || !U.is_number()) return {};
  return ", off by " + join(number_text(100.0 * seen.get<double>(), 100.0 * U.get<double>(), "%")) + " (accuracy " +
         percent(asked.get<double>()) + ")";
}

std::string coefficient_text(const Json& coefficient) {
  const Json &value = child_of(coefficient, "value"), &U95 = child_of(coefficient, "U95");
  if (!value.is_number() || !U95.is_number()) return kNoNumber;
  return join(number_text(value.get<double>(), U95.get<double>(), text_of(child_of(coefficient, "unit"))));
}

std::string verification_line(const Json& result) {
  const Json &dwell = child_of(result, "dwell"), &e_n = child_of(result, "e_n"), &reasons = child_of(result, "reasons");
  std::string text = dwell.is_number_integer() ? "of dwell " + dwell.dump() + ": " : "";
  text += text_of(child_of(result, "verdict"));
  text += error_text(child_of(result, "accuracy"));
  if (e_n.is_number()) text += ", E_n " + brief(e_n.get<double>(), 2);
  if (reasons.is_array() && !reasons.empty()) text += ": " + text_of(reasons.front());
  return text;
}

}  // namespace

std::string stored_model_text(const std::string& kind, const std::string& from, const std::string& result) {
  const Json of = Json::parse(from, nullptr, false), what = Json::parse(result, nullptr, false);
  return kind == "estimate" ? estimate_text(of, what) : verification_line(what);
}

std::vector<std::string> stored_cautions(const std::string& result) {
  std::vector<std::string> found;
  const Json all = Json::parse(result, nullptr, false);
  const Json& motion = child_of(all, "motion");
  if (std::string reason = text_of(child_of(all, "motion_reason")); !reason.empty()) found.push_back(std::move(reason));
  try {
    const Json& missing = child_of(motion, "missing");
    for (const MissingTerm& term : missing.is_array() ? missing_from(missing) : std::vector<MissingTerm>())
      found.push_back("the rig file may lack: " + missing_text(term));
  } catch (const json_reader::Mistake& mistake) {
    found.push_back(std::string("what the rig file may lack cannot be read: ") + mistake.what());
  }
  if (const auto objection = objection_in(all); objection && *objection)
    found.push_back("against dwell " + std::to_string((*objection)->dwell) + ": " + (*objection)->what);
  if (const Json& warnings = child_of(motion, "warnings"); warnings.is_array())
    for (const Json& warning : warnings) found.push_back(text_of(warning));
  return found;
}

std::vector<StoredElement> stored_elements(const std::string& result) {
  std::vector<StoredElement> found;
  const Json all = Json::parse(result, nullptr, false);
  const Json& elements = child_of(child_of(all, "motion"), "elements");
  if (!elements.is_array()) return found;
  for (const Json& element : elements) {
    const Json &k = child_of(element, "k"), &identifiable = child_of(element, "identifiable");
    const bool has = identifiable.is_boolean() && identifiable.get<bool>();
    found.push_back({k.is_number_integer() ? k.dump() : kNoNumber,
                     has ? coefficient_text(child_of(element, "stiffness")) : kNoNumber,
                     has ? coefficient_text(child_of(element, "damping")) : kNoNumber});
  }
  return found;
}

}  // namespace dwell
