#include "daemon/ctl/trend.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "daemon/ctl/watch_page.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

// The shortest line, s: a point in each block.
constexpr double kLeast_s = Trend::kEvery_s * static_cast<double>(Trend::kBlocks);

struct Line {
  std::string blocks;
  std::string reach;  // "± 0.20 %"
};

// The line of a coefficient through these values; the newest is its own.
Line line_of(const std::vector<double>& values, const Coefficient& newest) {
  double reach = 2.0 * newest.U95;
  for (const double value : values)
    if (std::isfinite(value)) reach = std::max(reach, std::abs(value - newest.value));
  if (!std::isfinite(reach) || newest.value == 0.0) return {std::string(values.size(), ' '), ""};
  const double percent = 100.0 * reach / std::abs(newest.value);
  char text[32];
  std::snprintf(text, sizeof text, percent < 10.0 ? "± %.2g %%" : "± %.0f %%", percent);
  return {sparkline(values, newest.value, reach), text};
}

}  // namespace

std::string sparkline(const std::vector<double>& values, double middle, double reach) {
  constexpr const char* kHeights[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string line;
  for (const double value : values) {
    if (!std::isfinite(value)) {
      line += ' ';
      continue;
    }
    const double part = reach > 0.0 ? (value - middle) / reach : 0.0;  // -1 … 1
    const double height = std::clamp(4.0 + 4.0 * part, 0.0, 7.0);
    line += kHeights[static_cast<std::size_t>(height)];
  }
  return line;
}

void Trend::take(const DwellView& view, double now_s) {
  Point point{now_s, now_s, {}, {}};
  const Dwell& dwell = view.dwell;
  // The last dwell of a run that was stopped stays in view, and so does one of an estimation that hangs: neither gives
  // new values.
  const bool stale = view.age && view.age->stale;
  if (has_coefficients(dwell) && dwell.state != State::complete && !stale) {
    for (const ElementEstimate& element : dwell.elements) {
      point.stiffness.push_back(element.identifiable ? element.stiffness.value : kNaN);
      point.damping.push_back(element.identifiable ? element.damping.value : kNaN);
    }
    // The first value of a dwell is that of all its data so far.
    std::string key = view.run.start_utc + " " + std::to_string(dwell.index.value_or(0));
    const double data_s = dwell.end_s - dwell.settled_s;
    if (key != dwell_ && dwell.state == State::measuring && data_s > 0.0) point.from_s -= data_s;
    dwell_ = std::move(key);
  }
  if (points_.size() > 1 && points_.back().t_s - points_[points_.size() - 2].t_s < kEvery_s) {
    const Point& replaced = points_.back();
    const bool reaches_back = replaced.from_s < replaced.t_s;
    if (reaches_back && !point.stiffness.empty()) point.from_s = replaced.from_s;
    points_.pop_back();
  }
  points_.push_back(std::move(point));
  while (points_.front().t_s < now_s - kSpan_s) points_.pop_front();
}

void Trend::take_earlier(const std::vector<EarlierDwell>& dwells, double now_s) {
  for (const EarlierDwell& dwell : dwells) {
    Point point{now_s - dwell.settled_ago_s, now_s - dwell.ended_ago_s, dwell.stiffness, dwell.damping};
    if (point.t_s < now_s - kSpan_s) continue;
    // What the stream told of it, or an earlier answer, is kept. Instants of two answers differ by their ways.
    const auto seen = std::find_if(points_.rbegin(), points_.rend(), [&point](const Point& p) {
      return !p.stiffness.empty() && p.t_s > point.from_s && p.t_s < point.t_s + kEvery_s;
    });
    if (seen != points_.rend()) {
      if (point.t_s - seen->t_s < kEvery_s) continue;
      point.from_s = seen->t_s;
    }
    const auto later =
        std::find_if(points_.begin(), points_.end(), [&point](const Point& p) { return p.t_s > point.t_s; });
    points_.insert(later, std::move(point));
  }
}

std::vector<double> Trend::in_blocks(std::vector<double> Point::*which, std::size_t element, double from_s,
                                     double until_s) const {
  std::vector<double> blocks(kBlocks, kNaN);
  const auto block_at = [&](double t_s) {
    const double part = std::clamp((t_s - from_s) / (until_s - from_s), 0.0, 1.0);
    return std::min(static_cast<std::size_t>(part * static_cast<double>(kBlocks)), kBlocks - 1);
  };
  for (const Point& point : points_) {
    if (point.t_s < from_s || point.t_s > until_s) continue;
    // Of several in a block the newest counts; one that gave none does not wipe out one that did.
    if (element >= (point.*which).size() || !std::isfinite((point.*which)[element])) continue;
    for (std::size_t block = block_at(point.from_s); block <= block_at(point.t_s); ++block)
      blocks[block] = (point.*which)[element];
  }
  return blocks;
}

Section Trend::section(const DwellView& view, double now_s, std::size_t columns) const {
  Section section;
  section.name = kTrend;
  if (!has_coefficients(view.dwell) || points_.size() < 2) return section;
  const double reach_s = std::clamp(now_s - points_.front().from_s, kLeast_s, kSpan_s);
  const bool wide = columns >= kWide;
  for (std::size_t i = 0; i < view.dwell.elements.size(); ++i) {
    const ElementEstimate& element = view.dwell.elements[i];
    if (!element.identifiable) continue;
    const auto line = [&](std::vector<double> Point::*which, const Coefficient& newest) {
      return line_of(in_blocks(which, i, now_s - reach_s, now_s), newest);
    };
    const Line c = line(&Point::stiffness, element.stiffness), r = line(&Point::damping, element.damping);
    const std::string left = pad_left(std::to_string(element.k), 7) + "  " + c.blocks + "  " + c.reach;
    if (wide) {
      section.body.push_back({pad_right(left, kDampingAt) + r.blocks + "  " + r.reach, Style::plain});
    } else {
      section.body.push_back({left, Style::plain});
      section.body.push_back({"     r   " + r.blocks + "  " + r.reach, Style::plain});
    }
  }
  if (section.body.empty()) return section;
  std::string text = "trend of the last " + age_text(reach_s) + "; middle: newest value, height: ± the % beside";
  for (const std::string& run : lacking_) text += "; " + run + " is missing: its file could not be read";
  std::vector<std::string> title = wrapped(text, columns);
  for (std::string& line : title) section.head.push_back({std::move(line), Style::hint});
  section.head.push_back(
      {wide ? pad_right("element  stiffness", kDampingAt) + "damping" : "element  stiffness, damping", Style::title});
  return section;
}

}  // namespace dwell::ctl
