#include "daemon/report/dwell_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string_view>

#include "core/base/printable.hpp"
#include "core/result/moved.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/motion_report.hpp"

namespace dwell {
namespace {

// Bytes of the character at the beginning of `text` if a terminal may obey it though JSON allows it as it is: DEL, C1
// controls, those of the writing direction, and U+2028 and U+2029, which some programs take for the end of a line.
std::size_t obeyed_bytes(std::string_view text) {
  if (static_cast<unsigned char>(text.front()) < 0x20) return 0;  // a line break between values
  for (const std::string_view separator : {"\u2028", "\u2029"})
    if (text.substr(0, separator.size()) == separator) return separator.size();
  return control_bytes(text);
}

// "\\u202e" for a character of one to three bytes of UTF-8.
std::string escape_of(std::string_view character) {
  constexpr std::array<unsigned, 3> kFirst{0x7F, 0x1F, 0x0F};  // bits of the first byte that belong to the code
  unsigned code = static_cast<unsigned char>(character.front()) & kFirst.at(character.size() - 1);
  for (const char c : character.substr(1)) code = code << 6U | (static_cast<unsigned char>(c) & 0x3FU);
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "\\u%04x", code);
  return text.data();
}

// The same JSON with such characters escaped. They stand within strings alone.
std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  while (!text.empty()) {
    const std::size_t obeyed = obeyed_bytes(text);
    out += obeyed > 0 ? escape_of(text.substr(0, obeyed)) : std::string(1, text.front());
    text.remove_prefix(obeyed > 0 ? obeyed : 1);
  }
  return out;
}

// Whether all is ASCII without DEL. Nearly every text is.
bool is_plain(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x7F; });
}

Json numbers(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(json_number(value));
  return array;
}

Json estimate(const Estimate& e) { return {{"value", json_number(e.value)}, {"u", json_number(e.u)}}; }

Json coefficient(const Coefficient& c, const char* unit) {
  return {{"value", json_number(c.value)}, {"u", json_number(c.u)},        {"dof", json_number(c.dof)},
          {"U95", json_number(c.U95)},     {"significant", c.significant}, {"unit", unit}};
}

// Most objects of a dwell's JSON are shares of budgets. An initializer list would copy each member several times.
Json budget_share(const BudgetShare& share) {
  Json::object_t object;
  object.reserve(5);
  object.emplace("source", share.source);
  if (share.kind != SourceKind::other) object.emplace("kind", to_string(share.kind));
  if (!share.channel.empty()) object.emplace("channel", share.channel);
  if (!share.device.empty()) object.emplace("device", share.device);
  if (share.mass > 0) object.emplace("mass", share.mass);
  object.emplace("stiffness_share", json_number(share.stiffness_share));
  object.emplace("damping_share", json_number(share.damping_share));
  return object;
}

Json phasor(const ChannelPhasor& estimated, const ChannelLabel& label) {
  // Numbers of a phasor that is not valid are withheld: who reads only the amplitude must not take one for a result.
  static const ChannelPhasor none;
  const ChannelPhasor& p = estimated.valid ? estimated : none;
  Json object = {{"channel", label.name},
                 {"unit", label.unit},
                 {"amplitude", json_number(std::abs(p.Y))},
                 {"phase_rad", json_number(std::arg(p.Y))},
                 {"u_amplitude", json_number(p.u_amplitude)},
                 {"u_phase_rad", json_number(p.u_phase_rad)},
                 {"u_relative_phase_rad", json_number(p.u_relative_phase_rad)},
                 {"mean", json_number(p.mean)},
                 {"harmonics", numbers(p.harmonics)},
                 {"sigma", json_number(p.sigma)},
                 {"samples", json_number(estimated.samples)},
                 {"valid", estimated.valid}};
  if (!estimated.valid) object["reason"] = estimated.reason;
  return object;
}

Json model_value(const ModelVerdict& model) {
  return {{"verdict", to_string(model.verdict)},
          {"consistent", model.consistent ? Json(*model.consistent) : Json(nullptr)},
          {"asked", json_number(model.asked)},
          {"seen", json_number(model.seen)},
          {"U", json_number(model.U)},
          {"objection", model.objection.empty() ? Json(nullptr) : Json(model.objection)}};
}

Json move_value(const CoefficientMove& move) {
  if (!std::isfinite(move.change)) return nullptr;
  return {{"change", move.change}, {"U95", json_number(move.U95)}, {"moved", move.moved}};
}

Json since_value(const SinceBefore& since) {
  Json elements = Json::array();
  for (const ElementMove& element : since.elements)
    elements.push_back(
        {{"k", element.k}, {"stiffness", move_value(element.stiffness)}, {"damping", move_value(element.damping)}});
  return {{"index", since.index},
          {"start_utc", json_text(since.start_utc)},
          {"end_s", json_number(since.end_s)},
          {"elements", std::move(elements)}};
}

Json limit_value(const JudgedLimit& limit, Motion motion) {
  const bool stiffness = limit.kind == CoefficientKind::stiffness;
  return {{"element", limit.element},
          {"coefficient", to_string(limit.kind)},
          {"low", json_number(limit.bounds.low)},
          {"high", json_number(limit.bounds.high)},
          {"unit", stiffness ? stiffness_unit(motion) : damping_unit(motion)},
          {"verdict", to_string(limit.verdict)},
          {"doubted", limit.doubted},
          {"reason", json_text(limit.reason)}};
}

constexpr const char* kDoubtKind = "doubt";  // beside the words of WarningKind

// Of what each line of `warnings` warns.
Json warned(const char* kind, const std::vector<int>& elements, const std::vector<std::string>& channels) {
  return {{"kind", kind}, {"elements", elements}, {"channels", channels}};
}

// `warnings`, `warned` and `doubts`.
void add_warnings(const Dwell& dwell, Json& object) {
  Json texts = Json::array(), kinds = Json::array(), doubts = Json::array();
  for (const Doubt& doubt : dwell.doubts) {
    doubts.push_back({{"elements", doubt.elements}, {"what", doubt.what}});
    texts.push_back(doubt.what);  // for whoever reads only these
    kinds.push_back(warned(kDoubtKind, doubt.elements, {}));
  }
  for (const Warning& warning : dwell.warnings) {
    texts.push_back(warning.what);
    kinds.push_back(warned(to_string(warning.kind), warning.elements, warning.channels));
  }
  // A reader who sees no coefficients must find the reason where the interface promises it.
  if (!std::isfinite(dwell.settled_s) && texts.empty()) {
    texts.push_back(kNotSettled + (dwell.settling_reason.empty() ? "no reason stated" : dwell.settling_reason));
    kinds.push_back(warned(to_string(WarningKind::not_settled), {}, {}));
  }
  object["warnings"] = std::move(texts);
  object["warned"] = std::move(kinds);
  object["doubts"] = std::move(doubts);
}

}  // namespace

Json json_element(const ElementEstimate& e, Motion motion, Detail detail) {
  Json object = {{"k", e.k},
                 {"identifiable", e.identifiable},
                 {"deformation",
                  {{"amplitude", json_number(e.deformation.value)},
                   {"u", json_number(e.deformation.u)},
                   {"unit", config::si_unit(Quantity::displacement, motion)}}}};
  Json budget = Json::array();
  if (e.identifiable) {
    object["stiffness"] = coefficient(e.stiffness, stiffness_unit(motion));
    object["damping"] = coefficient(e.damping, damping_unit(motion));
    object["loss_factor"] = estimate(e.loss_factor);
    if (detail == Detail::whole)
      for (const BudgetShare& share : e.budget) budget.push_back(budget_share(share));
  } else {
    object["stiffness"] = nullptr;
    object["damping"] = nullptr;
    object["loss_factor"] = nullptr;
    object["reason"] = e.reason;
  }
  if (detail == Detail::whole) object["budget"] = std::move(budget);
  return object;
}

Json json_square(const std::vector<double>& row_major) {
  const auto n = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(row_major.size()))));
  Json rows = Json::array();
  if (n * n != row_major.size()) return rows;
  for (std::size_t i = 0; i < n; ++i) {
    Json row = Json::array();
    for (std::size_t j = 0; j < n; ++j) row.push_back(json_number(row_major[i * n + j]));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json json_value(const DwellView& view, Detail detail) {
  const Dwell& d = view.dwell;
  const bool settled = std::isfinite(d.settled_s);
  Json object;
  object["index"] = d.index ? Json(*d.index) : Json(nullptr);
  object["state"] = to_string(d.state);
  if (d.state == State::complete) object["ended_by"] = to_string(d.ended_by);
  object["start_s"] = json_number(d.start_s);
  object["settled_s"] = json_number(d.settled_s);
  object["verdict_s"] = json_number(d.verdict_s);
  object["end_s"] = json_number(d.end_s);
  object["start_utc"] = json_text(view.run.start_utc);
  object["memory_time_s"] = json_number(d.memory_time_s);
  object["memory_time_predicted_s"] = json_number(d.memory_time_predicted_s);
  object["settles_in_s"] = json_number(d.settles_in_s);
  object["settling_reason"] = d.settling_reason;
  object["rig_sha256"] = json_text(view.run.rig_sha256);
  object["version"] = json_text(view.run.version);
  object["frequency_hz"] = estimate(d.frequency_hz);
  object["t_ref_s"] = json_number(d.t_ref_s);

  Json phasors = Json::array();
  const std::size_t count = std::min(d.phasors.size(), view.channels.size());
  for (std::size_t i = 0; i < count; ++i) phasors.push_back(phasor(d.phasors[i], view.channels[i]));
  object["phasors"] = std::move(phasors);

  Json elements = Json::array();
  if (settled) {
    for (const ElementEstimate& e : d.elements) elements.push_back(json_element(e, view.motion, detail));
  }
  object["elements"] = std::move(elements);
  // Not there without limits: results that were stored before there were any stay what a replay gives.
  for (const JudgedLimit& limit : view.limits) object["limits"].push_back(limit_value(limit, view.motion));
  if (detail == Detail::whole) object["covariance"] = settled ? json_square(d.covariance) : Json::array();

  add_warnings(d, object);
  object["unstated"] = d.unstated;
  object["motion"] = view.transient ? json_value(*view.transient, detail) : Json(nullptr);
  object["motion_reason"] = json_text(view.transient ? view.transient->estimate.reason : "");
  object["model"] = view.model ? model_value(*view.model) : Json(nullptr);
  if (view.age) {
    object["estimate_age_s"] = json_number(view.age->s);
    object["stale"] = view.age->stale;
    object["moved_beyond"] = json_number(settled ? moved_beyond(d) : kNaN);
    // People read it once a second: it is not among what moves.
    if (detail == Detail::whole) object["since"] = view.since ? since_value(*view.since) : Json(nullptr);
  }
  return object;
}

std::string dump(const Json& value, int indent) {
  std::string text = value.dump(indent, ' ', false, Json::error_handler_t::replace);
  return is_plain(text) ? text : escaped(text);
}

std::string to_json(const DwellView& view) { return dump(json_value(view)); }

std::string to_json(const Dwell& dwell, const Rig& rig, const RunInfo& run) {
  return to_json(make_view(dwell, rig, run));
}

}  // namespace dwell
