#include "daemon/ctl/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/result/moved.hpp"
#include "daemon/ctl/trend.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

struct Change {
  NumberText text{kNoNumber, "", ""};
  bool beyond = false;  // it has moved
};

// was: NaN: there is nothing to compare with. beyond: as moved_beyond() gives it.
Change change_of(const Coefficient& now, double was, double was_U95, double beyond) {
  if (!std::isfinite(now.value) || !std::isfinite(was) || was == 0.0) return {};
  const double percent = 100.0 * (now.value - was) / std::abs(was);
  const double U = 100.0 * std::hypot(now.U95, was_U95) / std::abs(was);
  Change change{number_text(percent, U, "%"), std::abs(percent) > beyond * U};
  if (change.text.value.find_first_of("123456789") != std::string::npos && percent > 0.0)
    change.text.value.insert(0, "+");
  return change;
}

double at(const std::vector<double>& values, std::size_t i) { return i < values.size() ? values[i] : kNaN; }

std::vector<std::string> cells_of(const std::vector<Change>& changes) {
  std::vector<NumberText> numbers;
  for (const Change& change : changes) numbers.push_back(change.text);
  std::vector<std::string> cells = join_aligned(numbers);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (changes[i].beyond) cells[i] += " moved";
  return cells;
}

}  // namespace

void Deviation::put(Settled dwell) {
  const auto known = std::find_if(newest_.begin(), newest_.end(), [&](const Settled& s) { return s.same(dwell); });
  if (known != newest_.end()) {
    if (known->ended && !dwell.ended) return;
    if (dwell.ended) dwell.t_s = std::min(dwell.t_s, known->t_s);
    newest_.erase(known);
  }
  const auto later = std::find_if(newest_.begin(), newest_.end(), [&](const Settled& s) { return s.t_s > dwell.t_s; });
  newest_.insert(later, std::move(dwell));
  if (newest_.size() > 2) newest_.erase(newest_.begin());
}

void Deviation::take(const DwellView& view, double now_s) {
  if (!has_coefficients(view.dwell)) return;
  Settled settled{
      view.run.start_utc, view.dwell.index.value_or(0), now_s, view.dwell.state == State::complete, {}, {}, {}, {}};
  for (const ElementEstimate& e : view.dwell.elements) {
    settled.stiffness.push_back(e.identifiable ? e.stiffness.value : kNaN);
    settled.stiffness_U95.push_back(e.stiffness.U95);
    settled.damping.push_back(e.identifiable ? e.damping.value : kNaN);
    settled.damping_U95.push_back(e.damping.U95);
  }
  put(std::move(settled));
}

void Deviation::take_earlier(const std::vector<EarlierDwell>& dwells, double now_s) {
  for (const EarlierDwell& dwell : dwells)
    put({dwell.run, dwell.index, now_s - dwell.ended_ago_s, true, dwell.stiffness, dwell.stiffness_U95, dwell.damping,
         dwell.damping_U95});
}

Section Deviation::section(const DwellView& view, double now_s, std::size_t columns) const {
  Section section;
  section.name = kDeviation;
  const Dwell& dwell = view.dwell;
  if (!has_coefficients(dwell) || dwell.state == State::complete) return section;
  const auto before = std::find_if(newest_.rbegin(), newest_.rend(), [&](const Settled& s) {
    return s.run != view.run.start_utc || s.index != dwell.index.value_or(0);
  });
  if (before == newest_.rend()) return section;

  std::vector<std::string> names;
  std::vector<Change> stiffness, damping;
  std::vector<Style> styles;
  const double beyond = moved_beyond(dwell);
  bool none = false;
  bool moved = false;
  for (std::size_t i = 0; i < dwell.elements.size(); ++i) {
    const ElementEstimate& e = dwell.elements[i];
    if (!e.identifiable) continue;
    names.push_back(std::to_string(e.k));
    stiffness.push_back(change_of(e.stiffness, at(before->stiffness, i), at(before->stiffness_U95, i), beyond));
    damping.push_back(change_of(e.damping, at(before->damping, i), at(before->damping_U95, i), beyond));
    none = none || !std::isfinite(at(before->stiffness, i)) || !std::isfinite(at(before->damping, i));
    moved = moved || stiffness.back().beyond || damping.back().beyond;
    styles.push_back(stiffness.back().beyond || damping.back().beyond ? Style::title : Style::plain);
  }
  if (names.empty()) return section;

  const std::vector<std::string> c = cells_of(stiffness), r = cells_of(damping);
  const bool wide = columns >= Trend::kWide;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string left = pad_left(names[i], 7) + "  " + c[i];
    section.body.push_back({wide ? pad_right(left, Trend::kDampingAt) + r[i] : left, styles[i]});
    if (!wide) section.body.push_back({"     r   " + r[i], styles[i]});
  }
  const std::string which = "dwell " + std::to_string(before->index);
  std::string title = "change since " + which;
  if (before->run != view.run.start_utc) title += " of an earlier run, " + age_text(now_s - before->t_s) + " ago";
  if (moved) title += "; moved: by more than chance (one false alarm in 20 dwells)";
  if (none) title += std::string("; ") + kNoNumber + ": " + which + " has no number to compare with";
  for (std::string& text : wrapped(title, columns)) section.head.push_back({std::move(text), Style::hint});
  section.head.push_back(
      {wide ? pad_right("element  stiffness", Trend::kDampingAt) + "damping" : "element  stiffness, damping",
       Style::title});
  return section;
}

}  // namespace dwell::ctl
