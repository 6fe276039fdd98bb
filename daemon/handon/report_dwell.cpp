#include "daemon/handon/report_dwell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "daemon/handon/html.hpp"
#include "daemon/handon/picture.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/limit_text.hpp"
#include "daemon/report/model_text.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::handon {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kSmallShare = 0.005;  // of a variance: smaller shares are shown as one sum

std::string percent(double part) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), part < 0.0995 ? "%.1f %%" : "%.0f %%", 100.0 * part);
  return std::isfinite(part) ? text.data() : kNoNumber;
}

std::string small_percent(double part) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2g %%", 100.0 * part);
  return std::isfinite(part) ? text.data() : kNoNumber;
}

// "60 % scale of y1, 30 % delay of y0, 10 % noise".
std::string budget_text(std::vector<BudgetShare> budget, double BudgetShare::*share) {
  std::sort(budget.begin(), budget.end(),
            [share](const BudgetShare& a, const BudgetShare& b) { return a.*share > b.*share; });
  std::string text;
  double rest = 0.0;
  for (const BudgetShare& part : budget) {
    if (part.*share < kSmallShare) {
      rest += part.*share;
    } else {
      text += (text.empty() ? "" : ", ") + percent(part.*share) + " " + part.source;
    }
  }
  if (rest >= kSmallShare) text += ", " + percent(rest) + " all others";
  return text;
}

// A number that may break before its ± and nowhere else: the table of coefficients must fit the page with long units.
std::string breakable(std::string text) {
  const std::size_t uncertainty = text.find(" ±");
  for (std::size_t at = text.find(' '); at != std::string::npos; at = text.find(' ', at + 1))
    if (at != uncertainty) text.replace(at, 1, "\u00a0");
  return text;
}

std::string coefficient_text(const Dwell& dwell, const ElementEstimate& e, const Coefficient& c, const char* unit) {
  if (!e.identifiable) return kNoNumber;
  return join(number_text(c.value, c.U95, unit)) + marks(dwell, e, c);
}

std::string coefficients(const DwellView& view) {
  const Dwell& dwell = view.dwell;
  if (dwell.elements.empty()) return html_paragraph("No coefficients: the dwell did not settle.");
  std::vector<std::vector<Markup>> values, budgets;
  std::vector<std::string> notes;
  for (const ElementEstimate& e : dwell.elements) {
    const std::string k = std::to_string(e.k);
    const auto degrees = [](const Coefficient& c) {
      return std::isfinite(c.dof) && c.dof < 1e6 ? axis_number(std::round(c.dof)) : std::string("∞");
    };
    values.push_back({k, breakable(coefficient_text(dwell, e, e.stiffness, stiffness_unit(view.motion))),
                      breakable(coefficient_text(dwell, e, e.damping, damping_unit(view.motion))),
                      e.identifiable
                          ? breakable(join(number_text(e.loss_factor.value, kNormal95 * e.loss_factor.u, "")))
                          : kNoNumber,
                      breakable(join(number_text(e.deformation.value, kNormal95 * e.deformation.u,
                                                 config::si_unit(Quantity::displacement, view.motion)))),
                      e.identifiable ? degrees(e.stiffness) : kNoNumber});
    if (e.identifiable) {
      budgets.push_back({k, budget_text(e.budget, &BudgetShare::stiffness_share),
                         budget_text(e.budget, &BudgetShare::damping_share)});
    } else {
      notes.push_back("Element " + k + " is not identifiable: " + e.reason);
    }
  }
  for (std::string& line : legend_of({&dwell})) notes.push_back(std::move(line));
  std::string html = "<div class=\"coefficients\">" +
                     html_table({{"element", true},
                                 {"stiffness c", true},
                                 {"damping r", true},
                                 {"loss factor", true},
                                 {"deformation", true},
                                 {"degrees of freedom", true}},
                                values) +
                     "</div>";
  html += html_list(notes, "notes");
  if (!budgets.empty())
    html += html_heading(4, "Uncertainty budget") +
            html_table({{"element", true}, {"part in u²(c)"}, {"part in u²(r)"}}, budgets);
  return html;
}

// A violated limit stands out; one without a verdict shows the reason.
std::string limits(const DwellView& view) {
  std::vector<std::vector<Markup>> rows;
  for (const JudgedLimit& limit : view.limits) {
    std::string measured = kNoNumber;
    for (const ElementEstimate& e : view.dwell.elements)
      if (e.k == limit.element)
        measured = limit.kind == CoefficientKind::stiffness
                       ? coefficient_text(view.dwell, e, e.stiffness, stiffness_unit(view.motion))
                       : coefficient_text(view.dwell, e, e.damping, damping_unit(view.motion));
    const bool none = limit.verdict == LimitVerdict::none, violated = limit.verdict == LimitVerdict::violated;
    rows.push_back({limited_text(limit), bounds_text(limit, view.motion), measured,
                    none       ? Markup("no verdict: " + limit.reason)
                    : violated ? Markup::made(std::string("<strong class=\"alarm\">violated</strong>"))
                               : Markup(to_string(limit.verdict))});
  }
  if (rows.empty()) return {};
  return html_heading(4, "Limits") +
         html_table({{"of"}, {"from the rig file"}, {"measured", true}, {"verdict"}}, rows) +
         html_list({"Kept: value ± U95 lies wholly within the limits; violated: wholly outside; undecided: partly "
                    "(ISO 14253-1)."},
                   "notes");
}

std::optional<std::size_t> reference_of(const Dwell& dwell, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (dwell.phasors[i].valid && std::abs(dwell.phasors[i].Y) > 0.0) return i;
  return std::nullopt;
}

std::string harmonics_text(const ChannelPhasor& p) {
  std::string text;
  for (std::size_t i = 0; i < p.harmonics.size(); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(i + 2) + "f " + small_percent(p.harmonics[i]);
  // Lines break between harmonics, not within one.
  for (std::size_t at = text.find(' '); at != std::string::npos; at = text.find(' ', at + 1))
    if (text[at - 1] != ',') text.replace(at, 1, "\u00a0");
  return text;
}

std::string phase_text(const ChannelPhasor& p, const ChannelPhasor& reference) {
  if (&p == &reference) return "0 °";
  return join(number_text(kDegrees * std::arg(p.Y / reference.Y), kDegrees * kNormal95 * p.u_relative_phase_rad, "°"));
}

// The units that occur, in order: arrows of one unit share a scale.
std::size_t group_of(std::vector<std::string>& units, const std::string& unit) {
  const auto found = std::find(units.begin(), units.end(), unit);
  if (found != units.end()) return static_cast<std::size_t>(found - units.begin());
  units.push_back(unit);
  return units.size() - 1;
}

std::string phasors(const DwellView& view) {
  const Dwell& dwell = view.dwell;
  const std::size_t count = std::min(dwell.phasors.size(), view.channels.size());
  const std::optional<std::size_t> reference = reference_of(dwell, count);
  if (!reference) return html_paragraph("No channel has a phasor.");
  std::vector<std::vector<Markup>> rows;
  std::vector<Arrow> arrows;
  std::vector<std::string> units, notes;
  for (std::size_t i = 0; i < count; ++i) {
    const ChannelPhasor& p = dwell.phasors[i];
    const ChannelLabel& label = view.channels[i];
    const std::string number = std::to_string(i + 1);
    if (!p.valid) {
      notes.push_back(number + " " + label.name + ": " + (p.reason.empty() ? "no reason stated" : p.reason));
      rows.push_back({number, label.name, kNoNumber, kNoNumber, kNoNumber});
      continue;
    }
    arrows.push_back({p.Y / dwell.phasors[*reference].Y * std::abs(dwell.phasors[*reference].Y),
                      static_cast<int>(i) + 1, group_of(units, label.unit)});
    rows.push_back({number, label.name, join(number_text(std::abs(p.Y), kNormal95 * p.u_amplitude, label.unit)),
                    phase_text(p, dwell.phasors[*reference]), harmonics_text(p)});
  }
  std::vector<double> longest(units.size(), 0.0);
  for (const Arrow& arrow : arrows) longest[arrow.group] = std::max(longest[arrow.group], std::abs(arrow.value));
  std::string scales;
  for (std::size_t g = 0; g < units.size(); ++g)
    scales += (scales.empty() ? "The outer circle is " : ", ") + join(number_text(longest[g], units[g], 4));
  const std::string caption = scales + ". Phases are relative to " + view.channels[*reference].name + ".";
  return "<div class=\"beside\"><figure>" + phasor_picture(arrows) + "<figcaption>" + escaped(caption) +
         "</figcaption></figure><div>" +
         html_table({{"no.", true}, {"channel"}, {"amplitude", true}, {"phase", true}, {"harmonics"}}, rows) +
         html_list(notes, "notes") + "</div></div>\n";
}

std::string verdicts(const DwellView& view) {
  const Dwell& d = view.dwell;
  const bool settled = std::isfinite(d.settled_s);
  const NumberText frequency = number_text(d.frequency_hz.value, kNormal95 * d.frequency_hz.u, "Hz");
  std::string transient = std::isfinite(d.memory_time_s) ? "decayed in " + seconds_text(d.memory_time_s, 2) : "";
  if (settled && std::isfinite(d.memory_time_predicted_s))
    transient += (transient.empty() ? "" : "; ") + seconds_text(d.memory_time_predicted_s, 2) +
                 " expected from the coefficients";
  return html_facts(
      {{"settled", settled ? "yes: data count from " + seconds_text(d.settled_s, 2) + " to " +
                                 seconds_text(d.end_s, 2) + ", first said at " + seconds_text(d.verdict_s, 2)
                           : std::string("no")},
       {"because", d.settling_reason},
       {"transient", transient},
       {"frequency", join(frequency)},
       {"model", view.model ? model_text(*view.model) : std::string()},
       {"agreement", agreement_text(view)}});
}

}  // namespace

std::string report_dwell(const DwellView& view) {
  const Dwell& dwell = view.dwell;
  std::vector<std::string> doubts, warnings;
  for (const Doubt& doubt : dwell.doubts) doubts.push_back(doubt_text(doubt));
  for (const Warning& warning : dwell.warnings)
    if (std::none_of(dwell.doubts.begin(), dwell.doubts.end(), [&](const Doubt& d) { return d.what == warning.what; }))
      warnings.push_back(warning.what);
  std::string title = headline(view);
  if (!title.empty() && title[0] == 'd') title[0] = 'D';
  std::string html = "<section class=\"dwell\">" + html_heading(3, title);
  html += html_list(doubts, "alarm");
  html += coefficients(view);
  html += limits(view);
  html += html_list(warnings, "warning");
  html += html_heading(4, "Verdicts") + verdicts(view);
  html += html_heading(4, "Phasors") + phasors(view);
  return html + "</section>\n";
}

}  // namespace dwell::handon
