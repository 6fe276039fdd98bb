#include "daemon/ctl/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "core/result/condition.hpp"
#include "daemon/ctl/json_member.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/model_text.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell::ctl {
namespace {

std::string fixed(double value, int decimals, const char* unit) {
  if (!std::isfinite(value) || std::fabs(value) >= 1e15) return kNoNumber;
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f %s", decimals, value, unit);
  return text.data();
}

// Whose clock, and its rate where it is known.
std::string clock_text(const Json& channel) {
  const std::string kind = text_member(channel, "clock");
  if (kind.empty()) return kNoNumber;
  const double rate_hz = number_member(channel, "clock_rate_hz");
  return std::isfinite(rate_hz) ? kind + " " + fixed(rate_hz, 3, "Hz") : kind;
}

// The calibration that the rig file states, and until when it holds.
std::string calibration_text(const Json& channel) {
  const Json* const calibration = member_of(channel, "calibration");
  if (calibration == nullptr || !calibration->is_object()) return kNoNumber;
  const std::string due = text_member(*calibration, "due");
  const Json* const overdue = member_of(*calibration, "overdue");
  const bool late = overdue != nullptr && overdue->is_boolean() && overdue->get<bool>();
  return text_member(*calibration, "id") + (due.empty() ? "" : ", due " + due) + (late ? ": overdue" : "");
}

// A reading in the unit that the operator chose in the rig file: no prefix of ours.
NumberText reading(double value, const std::string& unit) {
  if (!std::isfinite(value)) return {kNoNumber, "", ""};
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return {text.data(), "", pretty_unit(unit)};
}

NumberText interval(const ElementEstimate& e, const Coefficient& c, const char* unit) {
  return e.identifiable ? number_text(c.value, c.U95, unit) : NumberText{kNoNumber, "", ""};
}

// The verdict on a coefficient's limit, behind its number.
std::string limit_mark(const DwellView& view, int k, CoefficientKind kind) {
  for (const JudgedLimit& limit : view.limits)
    if (limit.element == k && limit.kind == kind && limit.verdict != LimitVerdict::none)
      return std::string(" limit ") + to_string(limit.verdict);
  return {};
}

// A line of the table of dwells: one element; the first one also tells of the dwell.
struct DwellRow {
  std::string dwell, ended_by, data, element, model, note;
  NumberText frequency, stiffness, damping;
  std::string stiffness_mark, damping_mark;  // behind the numbers
};

template <class Cell>
std::vector<Cell> column(const std::vector<DwellRow>& rows, Cell DwellRow::*cell) {
  std::vector<Cell> cells;
  for (const DwellRow& row : rows) cells.push_back(row.*cell);
  return cells;
}

std::vector<std::string> marked(const std::vector<DwellRow>& rows, NumberText DwellRow::*number,
                                std::string DwellRow::*mark) {
  std::vector<std::string> cells = join_aligned(column(rows, number));
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] += rows[i].*mark;
  return cells;
}

DwellRow element_row(const DwellView& view, const ElementEstimate& e) {
  const auto mark = [&](const Coefficient& c, CoefficientKind kind) {
    return e.identifiable ? marks(view.dwell, e, c) + limit_mark(view, e.k, kind) : "";
  };
  DwellRow row;
  row.element = std::to_string(e.k);
  row.stiffness = interval(e, e.stiffness, stiffness_unit(view.motion));
  row.damping = interval(e, e.damping, damping_unit(view.motion));
  row.stiffness_mark = mark(e.stiffness, CoefficientKind::stiffness);
  row.damping_mark = mark(e.damping, CoefficientKind::damping);
  row.note = e.identifiable ? "" : e.reason;
  return row;
}

std::vector<DwellRow> rows_of(const DwellView& view) {
  const Dwell& d = view.dwell;
  std::vector<DwellRow> rows;
  for (const ElementEstimate& e : d.elements) rows.push_back(element_row(view, e));
  if (rows.empty()) {
    rows.emplace_back();
    rows.back().note = "not settled" + (d.settling_reason.empty() ? "" : ": " + d.settling_reason);
  }
  const bool settled = std::isfinite(d.settled_s);
  DwellRow& first = rows.front();
  first.dwell = d.index ? std::to_string(*d.index) : "";
  first.ended_by = d.state == State::complete ? to_string(d.ended_by) : to_string(d.state);
  first.data = settled ? seconds_text(d.end_s - d.settled_s, 1) : kNoNumber;
  // Before settling, ± would be stated of a fit that holds part of the transient.
  first.frequency = settled ? number_text(d.frequency_hz.value, kNormal95 * d.frequency_hz.u, "Hz")
                            : number_text(d.frequency_hz.value, "Hz", 4);
  first.model = view.model ? model_brief(*view.model) : "";
  return rows;
}

std::vector<std::string> doubts_of(const DwellView& view) {
  const std::string whose = "dwell " + (view.dwell.index ? std::to_string(*view.dwell.index) : "") + ": ";
  std::vector<std::string> doubts;
  for (const Doubt& doubt : view.dwell.doubts) doubts.push_back(whose + doubt_text(doubt));
  if (view.model && !view.model->objection.empty()) doubts.push_back(whose + view.model->objection);
  return doubts;
}

}  // namespace

std::string channels_table(const Json& list) {
  std::vector<NumberText> values;
  std::vector<std::string> names, states, reasons, ages, rates, clocks, jitters, drifts;
  for (const Json& channel : list) {
    clocks.push_back(clock_text(channel));
    jitters.push_back(fixed(1e3 * number_member(channel, "jitter_s"), 3, "ms"));
    drifts.push_back(fixed(number_member(channel, "drift_ppm"), 1, "ppm"));
    names.push_back(text_member(channel, "name"));
    values.push_back(reading(number_member(channel, "value"), text_member(channel, "unit")));
    rates.push_back(fixed(number_member(channel, "rate_hz"), 1, "Hz"));
    ages.push_back(fixed(number_member(channel, "age_s"), 3, "s"));
    states.push_back(text_member(channel, "status"));
    reasons.push_back(text_member(channel, "reason"));
  }
  Table table;
  table.add("channel", std::move(names));
  table.add("status", std::move(states));
  table.add("value", join_aligned(values));
  table.add("age", std::move(ages), Align::right);
  table.add("rate", std::move(rates), Align::right);
  table.add("clock", std::move(clocks));
  table.add("jitter", std::move(jitters), Align::right);
  table.add("drift", std::move(drifts), Align::right);
  for (const char* name : {"lost", "received", "used", "dropped", "queued", "gaps"}) {
    std::vector<std::string> counts;
    for (const Json& channel : list) counts.push_back(integer_text(channel, name));
    table.add(name, std::move(counts), Align::right);
  }
  std::vector<std::string> calibrations;
  for (const Json& channel : list) calibrations.push_back(calibration_text(channel));
  if (std::any_of(calibrations.begin(), calibrations.end(), [](const std::string& text) { return text != kNoNumber; }))
    table.add("calibration", std::move(calibrations));
  table.add("", std::move(reasons));
  return table.text();
}

std::string recording_text(const Json& health) {
  std::string text;
  const Json* const recorder = member_of(health, "recorder");
  const Json* const alarms = recorder != nullptr ? member_of(*recorder, "alarms") : nullptr;
  if (alarms == nullptr || !alarms->is_array()) return text;
  for (const Json& alarm : *alarms)
    if (alarm.is_string()) text += "recording  " + printable(alarm.get<std::string>()) + "\n";
  return text;
}

std::string gpio_text(const Json& health) {
  std::string text;
  const auto gpio = health.is_object() ? health.find("gpio") : health.end();
  if (gpio == health.end() || !gpio->is_object()) return text;
  for (const auto& [name, line] : gpio->items()) {
    const double level = number_member(line, "level");
    if (const std::string reason = text_member(line, "reason"); !reason.empty()) {
      text += "gpio       " + printable(name) + " does not work: " + printable(reason) + "\n";
    } else if (name == "interlock" && std::isfinite(level)) {
      text += level == 0.0 ? "interlock  open: the shaker may not run\n" : "interlock  closed\n";
    }
  }
  return text;
}

std::string earlier_runs_text(const Json& runs) {
  const Json* const list = member_of(runs, "runs");
  std::size_t files = 0, dwells = 0;
  if (list == nullptr || !list->is_array()) return {};
  for (const Json& run : *list) {
    if (text_member(run, "dwells_at").empty()) continue;
    ++files;
    dwells += count_member(run, "dwells");
  }
  if (files == 0) return {};
  return "earlier runs: " + std::to_string(dwells) + (dwells == 1 ? " dwell in " : " dwells in ") +
         std::to_string(files) + (files == 1 ? " file" : " files") +
         "; dwellctl runs lists them, dwellctl show FILE and the page show the dwells of one\n";
}

std::string dwells_table(const std::vector<DwellView>& dwells) {
  std::vector<DwellRow> rows;
  std::vector<const Dwell*> shown;
  std::string text;
  // Whoever looks for a number finds it below what makes it worthless.
  for (const DwellView& view : dwells) {
    shown.push_back(&view.dwell);
    for (const std::string& doubt : doubts_of(view)) text += printable(doubt) + "\n";
    for (DwellRow& row : rows_of(view)) rows.push_back(std::move(row));
  }
  Table table;
  table.add("dwell", column(rows, &DwellRow::dwell), Align::right);
  table.add("ended by", column(rows, &DwellRow::ended_by));
  table.add("frequency", join_aligned(column(rows, &DwellRow::frequency)));
  table.add("data", column(rows, &DwellRow::data), Align::right);
  table.add("element", column(rows, &DwellRow::element), Align::right);
  table.add("stiffness", marked(rows, &DwellRow::stiffness, &DwellRow::stiffness_mark));
  table.add("damping", marked(rows, &DwellRow::damping, &DwellRow::damping_mark));
  if (std::any_of(rows.begin(), rows.end(), [](const DwellRow& row) { return !row.model.empty(); }))
    table.add("model", column(rows, &DwellRow::model));
  table.add("", column(rows, &DwellRow::note));
  text += table.text();
  for (const std::string& line : legend_of(shown)) text += printable(line) + "\n";
  return text;
}

bool Probed::answers() const {
  // Every condition in which readings come; else the status is the device's fault.
  for (const Condition condition :
       {Condition::ok, Condition::gated, Condition::overrange, Condition::held, Condition::clipped, Condition::stuck})
    if (status == to_string(condition)) return true;
  return false;
}

bool Probed::gated() const { return status == to_string(Condition::gated); }

std::string check_table(const std::vector<Probed>& channels) {
  std::vector<std::string> names, devices, rates, latencies, states, reasons;
  std::vector<NumberText> values;
  for (const Probed& channel : channels) {
    names.push_back(channel.name);
    devices.push_back(channel.device);
    values.push_back(reading(channel.value, channel.unit));
    rates.push_back(fixed(channel.rate_hz, 1, "Hz"));
    latencies.push_back(fixed(1e3 * channel.latency_s, 2, "ms"));
    states.push_back(channel.status);
    reasons.push_back(channel.reason == channel.status ? "" : channel.reason);
  }
  Table table;
  table.add("channel", std::move(names));
  table.add("status", std::move(states));
  table.add("device", std::move(devices));
  table.add("value", join_aligned(values));
  table.add("rate", std::move(rates), Align::right);
  table.add("latency", std::move(latencies), Align::right);
  table.add("", std::move(reasons));
  return table.text();
}

Json check_json(const std::vector<Probed>& channels) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json list = Json::array();
  for (const Probed& channel : channels) {
    list.push_back({{"name", channel.name},
                    {"device", channel.device},
                    {"value", number(channel.value)},
                    {"unit", channel.unit},
                    {"rate_hz", number(channel.rate_hz)},
                    {"latency_s", number(channel.latency_s)},
                    {"status", channel.status},
                    {"reason", channel.reason.empty() ? Json(nullptr) : Json(channel.reason)}});
  }
  return {{"channels", std::move(list)}};
}

std::vector<Probed> probed_from_json(const Json& list) {
  std::vector<Probed> channels;
  for (const Json& channel : list) {
    Probed probed;
    probed.name = text_member(channel, "name");
    probed.device = text_member(channel, "device");
    probed.value = number_member(channel, "value");
    probed.unit = text_member(channel, "unit");
    probed.rate_hz = number_member(channel, "rate_hz");
    probed.latency_s = number_member(channel, "latency_s");
    probed.status = text_member(channel, "status");
    probed.reason = text_member(channel, "reason");
    channels.push_back(std::move(probed));
  }
  return channels;
}

}  // namespace dwell::ctl
