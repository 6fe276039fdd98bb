#include "daemon/report/dwell_line.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "config/units.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell {
namespace {

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

std::string finished_line(const Dwell& dwell, const Rig& rig) {
  std::string line = "dwell " + (dwell.index ? std::to_string(*dwell.index) : std::string("-")) + " complete (" +
                     to_string(dwell.ended_by) + "): ";
  if (!std::isfinite(dwell.settled_s)) {
    line += "never settled";
    if (!dwell.settling_reason.empty()) line += ", " + dwell.settling_reason;
    return line;
  }
  line += number("%.6g Hz", dwell.frequency_hz.value) + number(", %.1f s counted", dwell.end_s - dwell.settled_s);
  for (const ElementEstimate& element : dwell.elements) {
    const std::string k = std::to_string(element.k);
    if (!element.identifiable) {
      line += "; c_" + k + ", r_" + k + " none: " + element.reason;
      continue;
    }
    line += "; c_" + k + " = " +
            join(number_text(element.stiffness.value, element.stiffness.U95, config::stiffness_unit(rig.motion)));
    line += ", r_" + k + " = " +
            join(number_text(element.damping.value, element.damping.U95, config::damping_unit(rig.motion)));
    const auto concerned = [&](const Doubt& doubt) { return concerns(doubt, element.k); };
    if (std::any_of(dwell.doubts.begin(), dwell.doubts.end(), concerned)) line += " (do not rely on it)";
  }
  for (const Doubt& doubt : dwell.doubts) line += "; doubt: " + doubt.what;
  for (const Warning& warning : dwell.warnings) line += "; warning: " + warning.what;
  if (const std::string unstated = unstated_text(dwell.unstated); !unstated.empty() && has_coefficients(dwell))
    line += "; " + unstated;
  return line;
}

std::string state_line(State before, const Dwell& now) {
  std::string line = std::string("state ") + to_string(before) + " -> " + to_string(now.state);
  if (now.index) line += ", dwell " + std::to_string(*now.index);
  if (!now.settling_reason.empty()) {
    line += ": " + now.settling_reason;
  } else if (!now.warnings.empty()) {
    line += ": " + now.warnings.front().what;
  }
  return line;
}

}  // namespace dwell
