#include "daemon/report/coefficient_table.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/missing_report.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell {

MotionView make_view(const MotionEstimate& estimate, const std::optional<Agreement>& agreement, const Rig& rig) {
  return {rig.motion, channel_labels(rig), estimate, agreement, kNaN, kNaN, 0};
}

std::string verdict_on(const Agreement& agreement) {
  const std::string of = std::string(to_string(agreement.kind)) + " of element " + std::to_string(agreement.element),
                    by = brief(agreement.over_U, 2) + " of the joint U of both";
  return agreement.contradicts ? "contradict these: the " + of + " differs by " + by
                               : "agree with these: the largest difference, in the " + of + ", is " + by;
}

std::string motion_text(const MotionView& view) {
  const MotionEstimate& m = view.estimate;
  std::string missing;
  for (const MissingTerm& term : m.missing) missing += "missing: " + printable(missing_text(term)) + "\n";
  if (!m.reason.empty()) return "any motion · none: " + printable(m.reason) + "\n" + missing;
  std::string text = "any motion · " + seconds_text(m.start_s, 2) + " to " + seconds_text(m.end_s, 2) + ", " +
                     std::to_string(m.readings) + " readings\n";
  Table table;
  std::vector<std::string> numbers;
  for (const ElementEstimate& e : m.elements) numbers.push_back(std::to_string(e.k));
  table.add("element", numbers, Align::right);
  table.add("stiffness", coefficient_cells(m.elements, &ElementEstimate::stiffness, stiffness_unit(view.motion)));
  table.add("damping", coefficient_cells(m.elements, &ElementEstimate::damping, damping_unit(view.motion)));
  text += table.text();
  for (const ElementEstimate& e : m.elements)
    if (!e.identifiable)
      text += "element " + std::to_string(e.k) + " is not identifiable: " + printable(e.reason) + "\n";
  text += missing;
  for (const std::string& what : m.unchecked) text += "cannot be checked here: " + printable(what) + "\n";
  if (view.agreement) text += "the dwell's coefficients " + verdict_on(*view.agreement) + "\n";
  for (const std::string& warning : m.warnings) text += "warning: " + printable(warning) + "\n";
  return text;
}

}  // namespace dwell
