#include "daemon/report/missing_report.hpp"

#include <cmath>

#include "core/base/wording.hpp"
#include "daemon/report/json_reader.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell {

Json json_value(const std::vector<MissingTerm>& missing) {
  Json all = Json::array();
  for (const MissingTerm& term : missing) {
    const bool valued = std::isfinite(term.value);
    all.push_back({{"what", term.what},
                   {"value", json_number(term.value)},
                   {"u", json_number(term.u)},
                   {"unit", valued ? Json(term.unit) : Json(nullptr)},
                   {"gain", json_number(term.gain)},
                   {"or", term.or_else}});
  }
  return all;
}

std::vector<MissingTerm> missing_from(const Json& list) {
  std::vector<MissingTerm> missing;
  for (const Json& value : list) {
    MissingTerm term;
    term.what = json_reader::string_of(value, "what");
    term.value = json_reader::real_of(value, "value");
    term.u = json_reader::real_of(value, "u");
    term.unit = json_reader::string_of(value, "unit");
    term.gain = json_reader::real_of(value, "gain");
    term.or_else = json_reader::strings_of(value, "or");
    missing.push_back(std::move(term));
  }
  return missing;
}

std::string missing_text(const MissingTerm& term) {
  std::string text = term.what;
  if (std::isfinite(term.value)) {
    text += ": " + plus_minus(term.value, kNormal95 * term.u, term.unit == "1" ? "" : unit_text(term.unit));
    while (text.back() == ' ') text.pop_back();
  }
  if (std::isfinite(term.gain)) text += ", gain " + brief(term.gain, 3);
  if (!term.or_else.empty()) text += "; not told from " + listed(term.or_else);
  return text;
}

}  // namespace dwell
