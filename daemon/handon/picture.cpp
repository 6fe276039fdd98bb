#include "daemon/handon/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "config/units.hpp"
#include "core/result/dwell.hpp"
#include "daemon/handon/html.hpp"
#include "daemon/handon/printf_text.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::handon {
namespace {

constexpr double kWidth = 640.0;

std::string open_svg(double width, double height, const std::string& title) {
  return format("<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" role=\"img\">", width, height, width,
                height) +
         "<title>" + escaped(title) + "</title>";
}

std::string text_at(double x, double y, const char* anchor, const std::string& text, const char* css = "") {
  return format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" class=\"%s\">", x, y, anchor, css) + escaped(text) +
         "</text>";
}

// The place of a trace in its picture, and the ranges of its axes.
struct Frame {
  double left = 62.0, right = kWidth - 4.0, top = 8.0, bottom = 84.0;
  double begin_s, end_s, low, high;

  [[nodiscard]] double x(double t_s) const { return left + (right - left) * (t_s - begin_s) / (end_s - begin_s); }
  [[nodiscard]] double y(double value) const { return bottom - (bottom - top) * (value - low) / (high - low); }
};

std::string axes(const Frame& f) {
  std::string svg = format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" class=\"frame\"/>", f.left,
                           f.top, f.right - f.left, f.bottom - f.top);
  for (const double value : ticks(f.low, f.high, 4)) {
    const double y = f.y(value);
    svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", f.left, y, f.right, y);
    svg += text_at(f.left - 5.0, y + 3.5, "end", axis_number(value));
  }
  for (const double t_s : ticks(f.begin_s, f.end_s, 8)) {
    svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", f.x(t_s), f.top, f.x(t_s),
                  f.bottom);
    svg += text_at(f.x(t_s), f.bottom + 13.0, "middle", axis_number(t_s));
  }
  return svg;
}

// Draws the bins as one outline: along the maxima, and back along the minima. Bins without a reading are skipped; there
// are some if there are fewer readings than bins.
std::string outline(const Trace& trace, const Frame& f) {
  const auto& bins = trace.bins();
  const double wide = (f.end_s - f.begin_s) / static_cast<double>(Trace::kBins);
  const std::size_t bridged = trace.count() == 0 ? 0 : 2 * Trace::kBins / trace.count();
  std::string path;
  std::vector<std::size_t> part;  // bins of the outline being drawn
  const auto draw = [&] {
    const auto x = [&](std::size_t i) { return f.x(f.begin_s + (static_cast<double>(i) + 0.5) * wide); };
    for (std::size_t k = 0; k < part.size(); ++k)
      path += format(k == 0 ? "M%.1f %.1f" : "L%.1f %.1f", x(part[k]), f.y(bins[part[k]].high));
    for (std::size_t k = part.size(); k > 0; --k)
      path += format("L%.1f %.1f", x(part[k - 1]), f.y(bins[part[k - 1]].low));
    if (!part.empty()) path += "Z";
    part.clear();
  };
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (bins[i].low > bins[i].high) continue;
    if (!part.empty() && i - part.back() > bridged + 1) draw();
    part.push_back(i);
  }
  draw();
  return path;
}

// Moves ascending angles apart, so that labels do not overlap.
void spread(std::vector<double>& angles, double apart) {
  for (int round = 0; round < 50; ++round)
    for (std::size_t i = 1; i < angles.size(); ++i) {
      const double lacking = apart - (angles[i] - angles[i - 1]);
      if (lacking <= 0.0) continue;
      angles[i - 1] -= lacking / 2.0;
      angles[i] += lacking / 2.0;
    }
}

constexpr std::array<const char*, 4> kGroups{"g0", "g1", "g2", "g3"};

}  // namespace

std::string axis_number(double value) { return format("%.6g", std::fabs(value) < 1e-300 ? 0.0 : value); }

std::vector<double> ticks(double low, double high, int most) {
  std::vector<double> values;
  if (!(high > low) || !std::isfinite(high - low)) return values;
  const double least = (high - low) / most;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  double step = 10.0 * decade;
  for (const double mantissa : {5.0, 2.0, 1.0})
    if (mantissa * decade >= least * (1.0 - 1e-9)) step = mantissa * decade;
  const double first = std::ceil(low / step - 1e-9);
  for (double i = first; i * step <= high + 1e-9 * step && values.size() < 100; i += 1.0) values.push_back(i * step);
  return values;
}

std::string trace_picture(const Trace& trace, const std::string& name, const std::string& unit, double begin_s,
                          double end_s, const std::vector<Shaded>& shaded) {
  Frame f{};
  f.begin_s = begin_s;
  f.end_s = end_s > begin_s ? end_s : begin_s + 1.0;
  const bool some = trace.low() <= trace.high();
  const double middle = some ? (trace.low() + trace.high()) / 2.0 : 0.0;
  const double half = some ? std::max((trace.high() - trace.low()) / 2.0, 1e-12 + 1e-9 * std::fabs(middle)) : 1.0;
  f.low = middle - 1.08 * half;
  f.high = middle + 1.08 * half;
  std::string svg = open_svg(kWidth, 102.0, name + " over time");
  std::string labels;
  for (const Shaded& part : shaded) {
    const double from = f.x(std::clamp(part.from_s, f.begin_s, f.end_s));
    const double to = f.x(std::clamp(part.to_s, f.begin_s, f.end_s));
    svg += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" class=\"shaded\"/>", from, f.top,
                  to - from, f.bottom - f.top);
    if (to - from > 14.0) labels += text_at((from + to) / 2.0, f.top + 11.0, "middle", part.label, "label over");
  }
  svg += axes(f);
  svg += "<path d=\"" + outline(trace, f) + "\" class=\"trace\"/>" + labels;
  svg += text_at(f.left - 14.0, f.bottom + 13.0, "end", "t / s", "axis");
  if (!some) svg += text_at((f.left + f.right) / 2.0, 50.0, "middle", "no readings");
  const std::string caption = name + (unit.empty() ? "" : " / " + pretty_unit(unit));
  return "<figure class=\"trace\"><figcaption>" + escaped(caption) + "</figcaption>" + svg + "</svg></figure>\n";
}

std::string phasor_picture(const std::vector<Arrow>& arrows) {
  constexpr double radius = 104.0, centre = 150.0, label_radius = 119.0;
  std::string svg = open_svg(2.0 * centre, 2.0 * centre, "phasors");
  for (const double part : {0.5, 1.0})
    svg += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" class=\"grid\"/>", centre, centre, part * radius);
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const double angle = degrees * std::numbers::pi / 180.0;
    svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", centre, centre,
                  centre + radius * std::cos(angle), centre - radius * std::sin(angle));
    // Outside the ring of the arrows' numbers: "1" beside "0°" would read as "10°".
    constexpr double beyond = label_radius + 10.0;
    if (degrees % 90 == 0)
      svg += text_at(centre + beyond * std::cos(angle), centre - beyond * std::sin(angle) + 3.5,
                     degrees == 0     ? "start"
                     : degrees == 180 ? "end"
                                      : "middle",
                     std::to_string(degrees) + "°", "axis");
  }
  std::array<double, kGroups.size()> longest{};
  for (const Arrow& arrow : arrows) {
    double& most = longest[arrow.group % kGroups.size()];
    most = std::max(most, std::abs(arrow.value));
  }
  std::vector<Arrow> sorted = arrows;
  std::sort(sorted.begin(), sorted.end(),
            [](const Arrow& a, const Arrow& b) { return std::arg(a.value) < std::arg(b.value); });
  std::vector<double> angles;
  for (const Arrow& arrow : sorted) angles.push_back(std::arg(arrow.value));
  spread(angles, 0.13);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const std::size_t group = sorted[i].group % kGroups.size();
    const double length = longest[group] > 0.0 ? radius * std::abs(sorted[i].value) / longest[group] : 0.0;
    const double angle = std::arg(sorted[i].value);
    const double x = centre + length * std::cos(angle), y = centre - length * std::sin(angle);
    svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"arrow %s\"/>", centre, centre, x, y,
                  kGroups[group]);
    for (const double side : {-0.35, 0.35})
      svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"arrow head %s\"/>", x, y,
                    x - 8.0 * std::cos(angle + side), y + 8.0 * std::sin(angle + side), kGroups[group]);
    const double lx = centre + label_radius * std::cos(angles[i]), ly = centre - label_radius * std::sin(angles[i]);
    svg += format("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"leader\"/>", x, y,
                  centre + (label_radius - 8.0) * std::cos(angles[i]),
                  centre - (label_radius - 8.0) * std::sin(angles[i]));
    svg += text_at(lx, ly + 4.0, "middle", std::to_string(sorted[i].number), "label");
  }
  return svg + "</svg>";
}

std::string chain_picture(const Rig& rig) {
  constexpr double box = 58.0, spring = 52.0, top = 14.0, height = 34.0, row = 96.0;
  constexpr int per_row = 5;
  const int masses = rig.mass_count();
  const int places = masses + 1 + (rig.boundary == Boundary::clamped ? 1 : 0);
  const int rows = (places + per_row - 1) / per_row;
  std::string svg = open_svg(kWidth, rows * row - 20.0, "the chain");
  for (int place = 0; place < places; ++place) {
    const double x = 1.0 + spring + (place % per_row) * (box + spring), y = top + (place / per_row) * row;
    const double middle = y + height / 2.0;
    const bool ground = place == masses + 1;
    if (place > 0) {
      std::string zigzag = format("M%.1f %.1fh8", x - spring, middle);
      for (int i = 0; i < 6; ++i)
        zigzag += format("l%.1f %.1f", i == 0 || i == 5 ? 3.0 : 6.0,
                         (i % 2 == 0 ? -1.0 : 1.0) * (i == 0 || i == 5 ? 6.0 : 12.0));
      svg += "<path d=\"" + zigzag + format("H%.1f", x) + "\" class=\"spring\"/>";
      svg += text_at(x - spring / 2.0, y - 2.0, "middle", "c" + std::to_string(place) + ", r" + std::to_string(place));
    }
    svg += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" class=\"%s\"/>", x, y, box, height,
                  place == 0 || ground ? "fixed" : "mass");
    svg += text_at(x + box / 2.0, middle + 4.0, "middle",
                   place == 0 ? "table"
                   : ground   ? "ground"
                              : "m" + std::to_string(place),
                   "label");
    if (place == 0 || ground) continue;
    const auto k = static_cast<std::size_t>(place - 1);
    const double u = k < rig.mass_u.size() ? rig.mass_u[k] : kNaN;
    const NumberText mass = std::isfinite(u) && u > 0.0
                                ? number_text(rig.masses[k], kNormal95 * u, config::mass_unit(rig.motion))
                                : number_text(rig.masses[k], config::mass_unit(rig.motion), 6);
    svg += text_at(x + box / 2.0, y + height + 14.0, "middle", join(mass));
  }
  return "<figure>" + svg + "</svg></figure>\n";
}

}  // namespace dwell::handon
