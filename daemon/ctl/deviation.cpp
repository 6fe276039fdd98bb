#include "daemon/ctl/deviation.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ctl/trend.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

NumberText number_of(const CoefficientMove& move) {
  if (!std::isfinite(move.change)) return {kNoNumber, "", ""};
  NumberText text = number_text(100.0 * move.change, 100.0 * move.U95, "%");
  if (text.value.find_first_of("123456789") != std::string::npos && move.change > 0.0) text.value.insert(0, "+");
  return text;
}

std::vector<std::string> cells_of(const std::vector<ElementMove>& elements, CoefficientMove ElementMove::*which) {
  std::vector<NumberText> numbers;
  for (const ElementMove& element : elements) numbers.push_back(number_of(element.*which));
  std::vector<std::string> cells = join_aligned(numbers);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if ((elements[i].*which).moved) cells[i] += " moved";
  return cells;
}

std::string title_of(const SinceBefore& since, bool earlier_run, double before_ago_s) {
  bool none = false, moved = false;
  for (const ElementMove& element : since.elements)
    for (const CoefficientMove& move : {element.stiffness, element.damping}) {
      none = none || !std::isfinite(move.change);
      moved = moved || move.moved;
    }
  const std::string which = "dwell " + std::to_string(since.index);
  std::string title = "change since " + which;
  if (earlier_run) title += " of an earlier run";
  if (earlier_run && std::isfinite(before_ago_s)) title += ", " + age_text(before_ago_s) + " ago";
  if (moved) title += "; moved: by more than chance (one false alarm in 20 dwells)";
  if (none) title += std::string("; ") + kNoNumber + ": " + which + " has no number to compare with";
  return title;
}

}  // namespace

Section deviation_section(const DwellView& view, double before_ago_s, std::size_t columns) {
  Section section;
  section.name = kDeviation;
  if (!view.since || view.since->elements.empty()) return section;
  const SinceBefore& since = *view.since;
  const std::vector<std::string> c = cells_of(since.elements, &ElementMove::stiffness),
                                 r = cells_of(since.elements, &ElementMove::damping);
  const bool wide = columns >= Trend::kWide;
  for (std::size_t i = 0; i < since.elements.size(); ++i) {
    const ElementMove& element = since.elements[i];
    const Style style = element.stiffness.moved || element.damping.moved ? Style::title : Style::plain;
    const std::string left = pad_left(std::to_string(element.k), 7) + "  " + c[i];
    section.body.push_back({wide ? pad_right(left, Trend::kDampingAt) + r[i] : left, style});
    if (!wide) section.body.push_back({"     r   " + r[i], style});
  }
  const bool earlier_run = since.start_utc != view.run.start_utc;
  for (std::string& text : wrapped(title_of(since, earlier_run, before_ago_s), columns))
    section.head.push_back({std::move(text), Style::hint});
  section.head.push_back(
      {wide ? pad_right("element  stiffness", Trend::kDampingAt) + "damping" : "element  stiffness, damping",
       Style::title});
  return section;
}

}  // namespace dwell::ctl
