#include "daemon/report/dwell_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <optional>

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

// The phase of `p` relative to `reference`, in (-180, 180] degrees; the uncertainties taken as independent.
NumberText relative_phase(const ChannelPhasor& p, const ChannelPhasor& reference) {
  constexpr double degrees = 180.0 / std::numbers::pi;
  if (&p == &reference) return {"0", "", "°"};
  const double U = kNormal95 * std::hypot(p.u_phase_rad, reference.u_phase_rad);
  return number_text(degrees * std::arg(p.Y / reference.Y), degrees * U, "°");
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

std::string coefficient_note(const Coefficient& c) { return c.significant || !std::isfinite(c.value) ? "" : " n.s."; }

std::vector<std::string> coefficient_cells(const std::vector<ElementEstimate>& elements,
                                           Coefficient ElementEstimate::*which, const char* unit) {
  std::vector<NumberText> numbers;
  for (const ElementEstimate& e : elements) {
    const Coefficient& c = e.*which;
    numbers.push_back(e.identifiable ? number_text(c.value, c.U95, unit) : NumberText{kNoNumber, "", ""});
  }
  std::vector<std::string> cells = join_aligned(numbers);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (elements[i].identifiable) cells[i] += coefficient_note(elements[i].*which);
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

void add_truth(Table& table, const std::vector<ElementEstimate>& elements, Coefficient ElementEstimate::*which,
               const std::vector<double>& truth, const char* unit) {
  std::vector<NumberText> values;
  std::vector<std::string> deviations;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const double value = i < truth.size() ? truth[i] : kNaN;
    const Coefficient& c = elements[i].*which;
    const double deviation = elements[i].identifiable ? (c.value - value) / c.u : kNaN;
    values.push_back(number_text(value, unit, 6));
    deviations.push_back(std::isfinite(deviation) ? format("%+.1f u", deviation) : kNoNumber);
  }
  table.add("true", join_aligned(values));
  table.add("off by", std::move(deviations), Align::right);
}

}  // namespace

std::string headline(const DwellView& view) {
  const Dwell& d = view.dwell;
  std::string text = d.index ? "dwell " + std::to_string(*d.index) + " · " : "";
  text += to_string(d.state);
  if (d.state == State::complete) text += std::string(", ended by: ") + to_string(d.ended_by);
  if (d.state == State::settling) {
    text += std::isfinite(d.settles_in_s) ? ", about " + seconds_text(d.settles_in_s, 1) + " left"
                                          : ", time left not known";
  }
  if (settled(d)) text += ", " + seconds_text(d.end_s - d.settled_s, 1) + " of data";
  return text + "\n";
}

std::string verdict_text(const DwellView& view) {
  const Dwell& d = view.dwell;
  std::string text;
  if (settled(d)) {
    text += "settled    data count from " + seconds_text(d.settled_s, 2) + " to " + seconds_text(d.end_s, 2) +
            ", first said at " + seconds_text(d.verdict_s, 2) + "\n";
  } else if (d.state != State::idle) {
    text += "settled    no\n";
  }
  if (!d.settling_reason.empty()) text += "reason     " + printable(d.settling_reason) + "\n";
  if (std::isfinite(d.memory_time_s) || std::isfinite(d.memory_time_predicted_s)) {
    text += "memory     " + seconds_text(d.memory_time_s, 2) + " measured, " +
            seconds_text(d.memory_time_predicted_s, 2) + " predicted from the coefficients\n";
  }
  if (std::isfinite(d.frequency_hz.value)) {
    text += "frequency  " + join(number_text(d.frequency_hz.value, kNormal95 * d.frequency_hz.u, "Hz")) + "\n";
  }
  return text;
}

std::string phasor_table(const DwellView& view) {
  const std::vector<ChannelPhasor>& phasors = view.dwell.phasors;
  const std::size_t count = std::min(phasors.size(), view.channels.size());
  std::optional<std::size_t> reference;
  for (std::size_t i = 0; i < count && !reference; ++i) {
    if (phasors[i].valid && std::abs(phasors[i].Y) > 0.0) reference = i;
  }
  std::vector<std::string> names;
  std::vector<NumberText> amplitudes;
  std::vector<NumberText> phases;
  std::vector<NumberText> means;
  std::vector<std::string> harmonics;
  std::vector<std::string> states;
  for (std::size_t i = 0; i < count; ++i) {
    const ChannelPhasor& p = phasors[i];
    const ChannelLabel& label = view.channels[i];
    names.push_back(label.name);
    const NumberText none{kNoNumber, "", ""};
    amplitudes.push_back(p.valid ? number_text(std::abs(p.Y), kNormal95 * p.u_amplitude, label.unit) : none);
    phases.push_back(p.valid && reference ? relative_phase(p, phasors[*reference]) : none);
    means.push_back(p.valid ? mean_text(p, label.unit) : none);
    harmonics.push_back(p.valid ? largest_harmonic(p) : kNoNumber);
    states.push_back(p.valid ? "ok" : p.reason.empty() ? "no reason stated" : p.reason);
  }
  Table table;
  table.add("channel", names);
  table.add("amplitude", join_aligned(amplitudes));
  table.add(reference ? "phase to " + names[*reference] : "phase", join_aligned(phases));
  table.add("mean", join_aligned(means));
  table.add("harmonic", harmonics, Align::right);
  table.add("status", states);
  return table.text();
}

std::string element_table(const DwellView& view, const Truth* truth) {
  const std::vector<ElementEstimate>& elements = view.dwell.elements;
  std::vector<std::string> numbers;
  std::string notes;
  bool insignificant = false;
  for (const ElementEstimate& e : elements) {
    numbers.push_back(std::to_string(e.k));
    if (!e.identifiable)
      notes += "element " + std::to_string(e.k) + " is not identifiable: " + printable(e.reason) + "\n";
    insignificant = insignificant || (e.identifiable && !(e.stiffness.significant && e.damping.significant));
  }
  if (insignificant) notes += "n.s.: not significant, smaller than its standard uncertainty\n";
  Table table;
  table.add("element", numbers, Align::right);
  table.add("stiffness", coefficient_cells(elements, &ElementEstimate::stiffness, stiffness_unit(view.motion)));
  if (truth != nullptr) {
    add_truth(table, elements, &ElementEstimate::stiffness, truth->stiffness, stiffness_unit(view.motion));
  }
  table.add("damping", coefficient_cells(elements, &ElementEstimate::damping, damping_unit(view.motion)));
  if (truth != nullptr) {
    add_truth(table, elements, &ElementEstimate::damping, truth->damping, damping_unit(view.motion));
  } else {
    table.add("most of u²(c)", source_cells(elements, &BudgetShare::stiffness_share));
    table.add("most of u²(r)", source_cells(elements, &BudgetShare::damping_share));
  }
  return table.text() + notes;
}

std::string dwell_text(const DwellView& view, const Truth* truth) {
  std::string text = headline(view) + verdict_text(view);
  if (const std::string table = phasor_table(view); !table.empty()) text += "\n" + table;
  if (const std::string table = element_table(view, truth); !table.empty()) {
    text += "\n" + table + "± is the half width of the 95 % interval\n";
  }
  std::string warnings;
  for (const Doubt& doubt : view.dwell.doubts)
    warnings += "do not rely on these numbers: " + printable(doubt.what) + "\n";
  for (const std::string& warning : view.dwell.warnings) {
    const bool said = warning == "not settled: " + view.dwell.settling_reason;
    if (!said) warnings += "warning: " + printable(warning) + "\n";
  }
  if (!warnings.empty()) text += "\n" + warnings;
  return text;
}

}  // namespace dwell
