#include "daemon/report/dwell_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <optional>

#include "daemon/report/coefficient_table.hpp"
#include "daemon/report/limit_text.hpp"
#include "daemon/report/model_text.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell {
namespace {

std::string format(const char* pattern, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

bool settled(const Dwell& dwell) { return std::isfinite(dwell.settled_s); }

// Digits of a number before the dwell has settled: the fit takes part of the transient for steady motion, which its ±
// does not cover, so none is shown.
constexpr int kProvisional = 3;

// The phase of `p` relative to `reference`, in (-180, 180] degrees.
NumberText relative_phase(const ChannelPhasor& p, const ChannelPhasor& reference, bool provisional) {
  constexpr double degrees = 180.0 / std::numbers::pi;
  if (&p == &reference) return {"0", "", "°"};
  const double phase = degrees * std::arg(p.Y / reference.Y);
  if (provisional) return number_text(phase, "°", kProvisional);
  return number_text(phase, degrees * kNormal95 * p.u_relative_phase_rad, "°");
}

// The mean to the digits that the amplitude has: it is known no better.
NumberText mean_text(const ChannelPhasor& p, const std::string& unit) {
  NumberText text = number_text(p.mean, kNormal95 * p.u_amplitude, unit);
  text.uncertainty.clear();
  return text;
}

std::string largest_harmonic(const ChannelPhasor& p) {
  const auto largest = std::max_element(p.harmonics.begin(), p.harmonics.end());
  if (largest == p.harmonics.end() || !std::isfinite(*largest)) return kNoNumber;
  const double percent = 100.0 * *largest;
  return format(percent < 99.5 ? "%.2g" : "%.0f", percent) + " % (" +
         std::to_string(2 + (largest - p.harmonics.begin())) + "f)";
}

bool insignificant(const Coefficient& c) { return !c.significant && std::isfinite(c.value); }

bool doubted(const Dwell& dwell, int k) {
  return std::any_of(dwell.doubts.begin(), dwell.doubts.end(), [k](const Doubt& doubt) { return concerns(doubt, k); });
}

std::vector<std::string> coefficient_cells(const Dwell& dwell, Coefficient ElementEstimate::*which, const char* unit) {
  const std::vector<ElementEstimate>& elements = dwell.elements;
  std::vector<NumberText> numbers;
  for (const ElementEstimate& e : elements) {
    const Coefficient& c = e.*which;
    numbers.push_back(e.identifiable ? number_text(c.value, c.U95, unit) : NumberText{kNoNumber, "", ""});
  }
  std::vector<std::string> cells = join_aligned(numbers);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (elements[i].identifiable) cells[i] += marks(dwell, elements[i], elements[i].*which);
  }
  return cells;
}

std::vector<std::string> source_cells(const std::vector<ElementEstimate>& elements, double BudgetShare::*share) {
  std::vector<std::string> cells;
  for (const ElementEstimate& e : elements) {
    const auto largest =
        std::max_element(e.budget.begin(), e.budget.end(),
                         [share](const BudgetShare& a, const BudgetShare& b) { return a.*share < b.*share; });
    if (!e.identifiable || largest == e.budget.end() || !std::isfinite((*largest).*share)) {
      cells.emplace_back(kNoNumber);
    } else {
      cells.push_back(format("%.0f %% ", 100.0 * (*largest).*share) + largest->source);
    }
  }
  return cells;
}

// Paragraphs, each broken to the width with its further lines indented.
Section paragraphs(const std::vector<std::string>& texts, std::size_t columns, std::size_t indent, Style style) {
  Section section;
  for (const std::string& text : texts)
    for (std::string& line : wrapped(printable(text), columns, indent))
      section.body.push_back({std::move(line), style});
  return section;
}

void append_notes(Section& to, const Section& notes) {
  to.body.insert(to.body.end(), notes.body.begin(), notes.body.end());
  to.notes += notes.body.size();
}

// The first part of a table that may be broken into several; the rest is for the end of the text.
Section take_first(std::vector<Section> tables, std::vector<Section>& rest) {
  rest.insert(rest.end(), tables.begin() + 1, tables.end());
  return std::move(tables.front());
}

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string whom(const Doubt& doubt) {
  if (doubt.elements.empty()) return "any element";
  std::vector<std::string> numbers;
  for (const int k : doubt.elements) numbers.push_back(std::to_string(k));
  return (numbers.size() > 1 ? "elements " : "element ") + list_of(numbers);
}

Section doubt_section(const DwellView& view, const TextOptions& options) {
  std::vector<std::string> texts;
  for (const Doubt& doubt : view.dwell.doubts) texts.push_back(doubt_text(doubt));
  Section section = paragraphs(texts, options.columns, 2, Style::alarm);
  section.name = kDoubts;
  return section;
}

// What stands below the coefficients: why some are missing, and the legend.
Section below(const Dwell& dwell, const TextOptions& options) {
  std::vector<std::string> texts;
  for (const ElementEstimate& e : dwell.elements)
    if (!e.identifiable) texts.push_back("element " + std::to_string(e.k) + " is not identifiable: " + e.reason);
  if (options.legend)
    for (std::string& text : legend_of({&dwell})) texts.push_back(std::move(text));
  return paragraphs(texts, options.columns, 2, Style::plain);
}

// The coefficients, in as many tables as the width asks for, the legend below the last; where the uncertainties'
// sources find no room beside them, they go to the rest.
std::vector<Section> element_sections(const DwellView& view, const TextOptions& options, std::vector<Section>& rest) {
  const Dwell& dwell = view.dwell;
  const std::vector<ElementEstimate>& elements = dwell.elements;
  const Truth* truth = options.truth;
  std::vector<std::string> numbers;
  std::vector<Style> styles;
  for (const ElementEstimate& e : elements) {
    numbers.push_back(std::to_string(e.k));
    styles.push_back(!options.age.empty()                    ? aged(options)
                     : e.identifiable && doubted(dwell, e.k) ? Style::doubted
                                                             : Style::plain);
  }
  Table table;
  table.add("element", numbers, Align::right);
  if (!options.age.empty()) table.add("age", std::vector<std::string>(elements.size(), options.age), Align::right);
  table.add("stiffness", coefficient_cells(dwell, &ElementEstimate::stiffness, stiffness_unit(view.motion)));
  if (truth != nullptr) {
    add_truth(table, elements, &ElementEstimate::stiffness, truth->stiffness, stiffness_unit(view.motion));
  }
  table.add("damping", coefficient_cells(dwell, &ElementEstimate::damping, damping_unit(view.motion)));
  if (truth != nullptr) {
    add_truth(table, elements, &ElementEstimate::damping, truth->damping, damping_unit(view.motion));
  }
  table.set_styles(std::move(styles));
  std::vector<Section> sections = table.sections(options.columns);
  if (sections.empty()) return sections;
  if (truth == nullptr) {
    const bool narrow = sections.size() > 1;
    Table sources;
    if (narrow) sources.add("element", numbers, Align::right);
    Table& where = narrow ? sources : table;
    where.add("most of u²(c)", source_cells(elements, &BudgetShare::stiffness_share));
    where.add("most of u²(r)", source_cells(elements, &BudgetShare::damping_share));
    if (narrow) {
      for (Section& section : sources.sections(options.columns)) rest.push_back(std::move(section));
    } else {
      sections = {take_first(table.sections(options.columns), rest)};
    }
  }
  for (Section& section : sections) section.name = kCoefficients;
  append_notes(sections.back(), below(dwell, options));
  return sections;
}

Section warning_section(const DwellView& view, const TextOptions& options) {
  std::vector<std::string> texts;
  for (const Warning& warning : view.dwell.warnings)
    if (warning.kind != WarningKind::not_settled) texts.push_back("warning: " + warning.what);
  if (settled(view.dwell) && contradicts(view)) texts.push_back("warning: " + agreement_text(view));
  Section section = paragraphs(texts, options.columns, 2, Style::plain);
  section.name = kWarnings;
  return section;
}

// On settling (the verdict, what it rests on, how long the transient took) and on the frequency.
Section verdict_section(const DwellView& view, const TextOptions& options) {
  const Dwell& d = view.dwell;
  std::vector<std::string> texts;
  if (settled(d)) {
    texts.push_back("settled    data count from " + seconds_text(d.settled_s, 2) + " to " + seconds_text(d.end_s, 2) +
                    ", first said at " + seconds_text(d.verdict_s, 2));
  } else if (d.state != State::idle) {
    texts.emplace_back("settled    no");
  }
  if (!d.settling_reason.empty()) texts.push_back("reason     " + d.settling_reason);
  std::string transient;
  const bool some = settled(d) || d.state == State::settling;  // else the numbers are of a dwell that is over
  if (some && std::isfinite(d.memory_time_s)) transient = "decayed in " + seconds_text(d.memory_time_s, 2);
  if (some && std::isfinite(d.memory_time_predicted_s)) {
    transient += (transient.empty() ? "" : "; ") + seconds_text(d.memory_time_predicted_s, 2) +
                 " expected from the coefficients";
  }
  if (!transient.empty()) texts.push_back("transient  " + transient);
  if (const std::string frequency = frequency_text(d); options.frequency && !frequency.empty())
    texts.push_back("frequency  " + frequency);
  if (const std::string text = agreement_text(view); settled(d) && !text.empty() && !contradicts(view))
    texts.push_back("agreement  " + text);
  if (view.model) texts.push_back("model      " + model_text(*view.model));
  return paragraphs(texts, options.columns, 11, options.age.empty() ? Style::plain : aged(options));
}

// Phases are relative to the first channel that has one, which the column's title names.
Section phasor_section(const DwellView& view, const TextOptions& options, std::vector<Section>& rest) {
  const std::vector<ChannelPhasor>& phasors = view.dwell.phasors;
  const std::size_t count = std::min(phasors.size(), view.channels.size());
  if (count == 0) return {};
  std::optional<std::size_t> reference;
  for (std::size_t i = 0; i < count && !reference; ++i) {
    if (phasors[i].valid && std::abs(phasors[i].Y) > 0.0) reference = i;
  }
  const bool provisional = !settled(view.dwell);
  std::vector<std::string> names;
  std::vector<std::string> ages;
  std::vector<NumberText> amplitudes;
  std::vector<NumberText> phases;
  std::vector<NumberText> means;
  std::vector<std::string> harmonics;
  std::vector<std::string> notes;
  std::vector<Style> styles;
  for (std::size_t i = 0; i < count; ++i) {
    const ChannelPhasor& p = phasors[i];
    const ChannelLabel& label = view.channels[i];
    const ChannelNote note = i < options.channels.size() ? options.channels[i] : ChannelNote{};
    names.push_back(label.name);
    const NumberText none{kNoNumber, "", ""};
    const double amplitude = std::abs(p.Y);
    amplitudes.push_back(!p.valid      ? none
                         : provisional ? number_text(amplitude, label.unit, kProvisional)
                                       : number_text(amplitude, kNormal95 * p.u_amplitude, label.unit));
    phases.push_back(p.valid && reference ? relative_phase(p, phasors[*reference], provisional) : none);
    means.push_back(p.valid ? mean_text(p, label.unit) : none);
    harmonics.push_back(p.valid ? largest_harmonic(p) : kNoNumber);
    ages.push_back(!note.age.empty() ? note.age : options.age);
    styles.push_back(ages.back().empty() ? Style::plain : note.age.empty() ? aged(options) : Style::old);
    std::string text = p.valid ? "" : p.reason.empty() ? "no reason stated" : p.reason;
    // The channel's own word on why it delivers nothing says more.
    if (!note.status.empty() && text.rfind("stale", 0) == 0) text.clear();
    if (!note.status.empty() && text.find(note.status) == std::string::npos) {
      text += (text.empty() ? "now " : "; now ") + note.status;
    }
    if (!text.empty()) notes.push_back(label.name + ": " + text);
  }
  const bool some_old = std::any_of(ages.begin(), ages.end(), [](const std::string& age) { return !age.empty(); });
  Table table;
  table.add("channel", names);
  if (some_old) table.add("age", std::move(ages), Align::right);
  table.add("amplitude", join_aligned(amplitudes));
  table.add(reference ? "phase to " + names[*reference] : "phase", join_aligned(phases));
  if (!provisional) {
    table.add("mean", join_aligned(means));
    table.add("harmonic", harmonics, Align::right);
  }
  table.set_styles(std::move(styles));
  Section section = take_first(table.sections(options.columns), rest);
  if (provisional && reference) {
    append_notes(section, paragraphs({"not settled: part of the transient is in these numbers, so they have no ±"},
                                     options.columns, 2, Style::plain));
  }
  append_notes(section, paragraphs(notes, options.columns, 2, Style::plain));
  return section;
}

// The reason, to be put behind the name of a state; empty: none.
std::string because(const Dwell& dwell) { return dwell.settling_reason.empty() ? "" : ": " + dwell.settling_reason; }

}  // namespace

std::string marks(const Dwell& dwell, const ElementEstimate& element, const Coefficient& coefficient) {
  return std::string(insignificant(coefficient) ? " n.s." : "") + (doubted(dwell, element.k) ? " ?" : "");
}

std::string doubt_text(const Doubt& doubt) { return "do not rely on " + whom(doubt) + ": " + doubt.what; }

std::vector<std::string> legend_of(const std::vector<const Dwell*>& dwells) {
  bool any = false;
  bool some_insignificant = false;
  bool some_doubted = false;
  std::vector<std::string> unstated;
  for (const Dwell* dwell : dwells) {
    bool here = false;
    for (const ElementEstimate& e : dwell->elements) {
      if (!e.identifiable) continue;
      here = true;
      some_insignificant = some_insignificant || insignificant(e.stiffness) || insignificant(e.damping);
      some_doubted = some_doubted || doubted(*dwell, e.k);
    }
    any = any || here;
    for (const std::string& what : dwell->unstated)
      if (here && std::find(unstated.begin(), unstated.end(), what) == unstated.end()) unstated.push_back(what);
  }
  if (!any) return {};
  std::vector<std::string> texts{"± is the half width of the 95 % interval, if the rig is as its file says"};
  if (some_insignificant) texts[0] += "; n.s.: not significant, smaller than its standard uncertainty";
  if (some_doubted) texts[0] += "; ?: do not rely on it, the reason stands with the dwell";
  if (std::string text = unstated_text(unstated); !text.empty()) texts.push_back(std::move(text));
  return texts;
}

std::string unstated_text(const std::vector<std::string>& unstated) {
  if (unstated.empty()) return {};
  return "± covers only noise, clock and what the rig file states; not stated: " + list_of(unstated);
}

std::string frequency_text(const Dwell& d) {
  if (!std::isfinite(d.frequency_hz.value)) return {};
  if (!settled(d)) return join(number_text(d.frequency_hz.value, "Hz", kProvisional + 1)) + " so far";
  return join(number_text(d.frequency_hz.value, kNormal95 * d.frequency_hz.u, "Hz"));
}

std::string headline(const DwellView& view) {
  const Dwell& d = view.dwell;
  std::string text = d.index ? "dwell " + std::to_string(*d.index) + " · " : "";
  text += to_string(d.state);
  if (d.state == State::complete) text += std::string(", ended by: ") + to_string(d.ended_by);
  if (d.state == State::settling) {
    text += std::isfinite(d.settles_in_s) ? ", about " + age_text(d.settles_in_s) + " left"
                                          : ", time left not known" + because(d);
  }
  if (d.state == State::fault) text += because(d);
  if (settled(d)) text += ", " + seconds_text(d.end_s - d.settled_s, 1) + " of data";
  return text;
}

std::vector<Section> dwell_sections(const DwellView& view, const TextOptions& options) {
  std::vector<Section> rest;
  std::vector<Section> sections;
  sections.push_back(doubt_section(view, options));
  for (Section& section : element_sections(view, options, rest)) sections.push_back(std::move(section));
  sections.push_back(limit_section(view, options));
  for (Section& section : transient_sections(view, options)) sections.push_back(std::move(section));
  sections.push_back(warning_section(view, options));
  sections.push_back(verdict_section(view, options));
  sections.push_back(phasor_section(view, options, rest));
  sections.insert(sections.end(), rest.begin(), rest.end());
  sections.erase(std::remove_if(sections.begin(), sections.end(), [](const Section& s) { return s.body.empty(); }),
                 sections.end());
  return sections;
}

std::string dwell_text(const DwellView& view, const Truth* truth) {
  TextOptions options;
  options.truth = truth;
  std::string first = headline(view);
  if (view.age && view.age->stale) {
    options.age = age_text(view.age->s);
    first = (std::isfinite(view.age->s) ? "STALE, from " + options.age + " ago: " : "no estimate yet: ") + first;
  }
  std::vector<Section> sections = dwell_sections(view, options);
  sections.insert(sections.begin(), Section{{}, {{first, Style::plain}}, {}});
  return plain_text(sections);
}

}  // namespace dwell
