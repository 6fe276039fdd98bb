#include "daemon/report/model_text.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/wording.hpp"
#include "daemon/report/coefficient_table.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell {
namespace {

std::string stretch_text(const MotionEstimate& m) {
  const std::string start = seconds_text(m.start_s, 1);
  return start.substr(0, start.find(' ')) + " to " + seconds_text(m.end_s, 1);
}

// Lines above a table, repeated where it goes on overleaf.
std::vector<TextLine> title(const MotionEstimate& m, const TextOptions& options) {
  std::vector<TextLine> lines;
  const std::string text = "from the transient, " + stretch_text(m) + ", an estimate before the verdict:";
  for (std::string& line : wrapped(text, options.columns, 2))
    lines.push_back({std::move(line), options.age.empty() ? Style::tentative : aged(options)});
  return lines;
}

// The legend of the estimate's ± and marks. `beside` has what the rig file leaves unstated: both have the same rig
// file.
std::vector<std::string> legend_below(const MotionEstimate& m, const Dwell& beside) {
  Dwell shown;
  shown.elements = m.elements;
  shown.unstated = beside.unstated;
  return legend_of({&shown});
}

void add_notes(const MotionEstimate& m, const Dwell& beside, const TextOptions& options, Section& to) {
  std::vector<std::string> texts;
  for (const ElementEstimate& e : m.elements)
    if (!e.identifiable)
      texts.push_back("element " + std::to_string(e.k) + " is not determined by the transient so far: " + e.reason);
  for (const std::string& warning : m.warnings) texts.push_back("from the transient, warning: " + warning);
  for (std::string& text : legend_below(m, beside)) texts.push_back(std::move(text));
  for (const std::string& text : texts)
    for (std::string& line : wrapped(printable(text), options.columns, 2)) {
      to.body.push_back({std::move(line), Style::plain});
      ++to.notes;
    }
}

}  // namespace

std::vector<Section> transient_sections(const DwellView& view, const TextOptions& options) {
  if (!view.transient || std::isfinite(view.dwell.settled_s)) return {};
  const MotionEstimate& m = view.transient->estimate;
  if (!m.reason.empty()) {
    Section none;
    for (std::string& line : wrapped("from the transient: no coefficients: " + printable(m.reason), options.columns, 2))
      none.body.push_back({std::move(line), Style::plain});
    return {none};
  }
  std::vector<std::string> numbers;
  for (const ElementEstimate& e : m.elements) numbers.push_back(std::to_string(e.k));
  const Truth* const truth = options.truth;
  Table table;
  table.add("element", numbers, Align::right);
  if (!options.age.empty()) table.add("age", std::vector<std::string>(numbers.size(), options.age), Align::right);
  table.add("stiffness", coefficient_cells(m.elements, &ElementEstimate::stiffness, stiffness_unit(view.motion)));
  if (truth != nullptr)
    add_truth(table, m.elements, &ElementEstimate::stiffness, truth->stiffness, stiffness_unit(view.motion));
  table.add("damping", coefficient_cells(m.elements, &ElementEstimate::damping, damping_unit(view.motion)));
  if (truth != nullptr)
    add_truth(table, m.elements, &ElementEstimate::damping, truth->damping, damping_unit(view.motion));
  table.set_styles(std::vector<Style>(numbers.size(), options.age.empty() ? Style::tentative : aged(options)));
  std::vector<Section> sections = table.sections(options.columns);
  if (sections.empty()) return sections;
  std::vector<TextLine> head = title(m, options);
  for (Section& section : sections) section.head.insert(section.head.begin(), head.begin(), head.end());
  add_notes(m, view.dwell, options, sections.back());
  return sections;
}

bool contradicts(const DwellView& view) {
  return view.transient && view.transient->agreement && view.transient->agreement->contradicts;
}

std::string agreement_text(const DwellView& view) {
  if (!view.transient) return {};
  if (const std::string& reason = view.transient->estimate.reason; !reason.empty())
    return "not known, since any motion gives no coefficients: " + reason;
  if (!view.transient->agreement) return {};
  return "the coefficients of any motion, " + stretch_text(view.transient->estimate) + ", " +
         verdict_on(*view.transient->agreement);
}

std::string model_brief(const ModelVerdict& model) {
  std::string text = to_string(model.verdict);
  if (!model.consistent.value_or(true)) text += ", not consistent";
  if (!model.objection.empty()) text += ", objection";
  return text;
}

std::string model_text(const ModelVerdict& model) {
  std::string text = to_string(model.verdict);
  if (std::isfinite(model.seen)) text += ", off by " + join(number_text(100.0 * model.seen, 100.0 * model.U, "%"));
  text += " (accuracy " + percent(model.asked) + ")";
  if (model.consistent && !*model.consistent) text += "; not consistent: dwellctl verify says why";
  if (!model.objection.empty()) text += "; " + model.objection;
  return text;
}

}  // namespace dwell
