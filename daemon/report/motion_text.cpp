#include <algorithm>
#include <cmath>

#include "daemon/report/coefficient_table.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/missing_report.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell {
namespace {

// compared: coefficients whose largest difference it is. They contradict each other where noise makes as much in less
// than 5 % of cases (Bonferroni).
std::string e_n_text(double e_n, int compared) {
  const bool contradict = e_n > 1 && compared * std::erfc(std::sqrt(2.0) * e_n) < 0.05;
  return "the dwell's coefficients " + std::string(contradict ? "contradict" : "agree with") +
         " these: largest difference over its U is " + join(number_text(e_n, "", 2));
}

}  // namespace

MotionView make_view(const MotionEstimate& estimate, double e_n, const Rig& rig) {
  return {rig.motion, channel_labels(rig), estimate, e_n, kNaN, kNaN, 0};
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
  int compared = 0;
  for (const ElementEstimate& e : m.elements) compared += e.identifiable ? 2 : 0;
  if (std::isfinite(view.e_n)) text += e_n_text(view.e_n, compared) + "\n";
  for (const std::string& warning : m.warnings) text += "warning: " + printable(warning) + "\n";
  return text;
}

}  // namespace dwell
