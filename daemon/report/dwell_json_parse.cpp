#include <cmath>
#include <complex>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_reader.hpp"
#include "daemon/report/missing_report.hpp"
#include "daemon/report/motion_report.hpp"

namespace dwell {
namespace {

using namespace json_reader;

Estimate estimate(const Json& value) {
  if (value.is_null()) return {};
  return {real_of(value, "value"), real_of(value, "u")};
}

Coefficient coefficient(const Json& value) {
  if (value.is_null()) return {};
  Coefficient c;
  c.value = real_of(value, "value");
  c.u = real_of(value, "u");
  c.dof = real_of(value, "dof");
  c.U95 = real_of(value, "U95");
  c.significant = boolean_of(value, "significant");
  return c;
}

ChannelPhasor phasor(const Json& value) {
  ChannelPhasor p;
  const double amplitude = real_of(value, "amplitude");
  const double phase_rad = real_of(value, "phase_rad");
  p.Y = {amplitude * std::cos(phase_rad), amplitude * std::sin(phase_rad)};
  p.u_amplitude = real_of(value, "u_amplitude");
  p.u_phase_rad = real_of(value, "u_phase_rad");
  p.u_relative_phase_rad = real_of(value, "u_relative_phase_rad");
  p.mean = real_of(value, "mean");
  for (const Json& h : array_of(value, "harmonics")) p.harmonics.push_back(real(h, "harmonics"));
  p.sigma = real_of(value, "sigma");
  p.samples = real_of(value, "samples");
  p.valid = boolean_of(value, "valid");
  if (!p.valid) p.reason = string_of(value, "reason");
  return p;
}

// The kind and whose it is: of a program that knew none, they are left out.
BudgetShare budget_share(const Json& value) {
  BudgetShare share{
      string_of(value, "source"), real_of(value, "stiffness_share"), real_of(value, "damping_share"), {}, {}};
  if (value.contains("kind")) share.kind = named(string_of(value, "kind"), "kind", SourceKind::second_order);
  if (value.contains("channel")) share.channel = string_of(value, "channel");
  if (value.contains("device")) share.device = string_of(value, "device");
  if (value.contains("mass")) share.mass = integer(value["mass"], "mass");
  return share;
}

ElementEstimate element(const Json& value, Motion& motion) {
  ElementEstimate e;
  e.k = integer(member(value, "k"), "k");
  e.identifiable = boolean_of(value, "identifiable");
  if (!e.identifiable) e.reason = string_of(value, "reason");
  const Json& deformation = member(value, "deformation");
  e.deformation = {real_of(deformation, "amplitude"), real_of(deformation, "u")};
  if (string_of(deformation, "unit") == config::si_unit(Quantity::displacement, Motion::rotation))
    motion = Motion::rotation;
  e.stiffness = coefficient(member(value, "stiffness"));
  e.damping = coefficient(member(value, "damping"));
  e.loss_factor = estimate(member(value, "loss_factor"));
  for (const Json& share : array_of(value, "budget")) e.budget.push_back(budget_share(share));
  return e;
}

Agreement agreement(const Json& value) {
  return {integer(member(value, "element"), "element"),
          named(string_of(value, "coefficient"), "coefficient", CoefficientKind::damping), real_of(value, "difference"),
          !boolean_of(value, "agrees"), real_of(value, "e_n")};
}

std::shared_ptr<const MotionView> motion_of(const Json& value) {
  const auto found = value.find("motion"), reason = value.find("motion_reason");
  if (found == value.end()) return nullptr;  // of a service that does not tell
  MotionView view;
  MotionEstimate& m = view.estimate;
  if (reason != value.end() && reason->is_string()) m.reason = reason->get<std::string>();
  if (found->is_null() && m.reason.empty()) return nullptr;
  if (!found->is_null()) {
    const Json& motion = *found;
    m.start_s = real_of(motion, "start_s");
    m.end_s = real_of(motion, "end_s");
    for (const Json& e : array_of(motion, "elements")) m.elements.push_back(element(e, view.motion));
    m.readings = static_cast<std::size_t>(integer(member(motion, "readings"), "readings"));
    m.warnings = strings_of(motion, "warnings");
    m.missing = missing_from(array_of(motion, "missing"));
    m.unchecked = strings_of(motion, "cannot_be_checked");
    if (const Json& with = member(motion, "agrees_with_dwell"); !with.is_null()) view.agreement = agreement(with);
  }
  return std::make_shared<const MotionView>(std::move(view));
}

std::optional<ModelVerdict> model_of(const Json& value) {
  const auto found = value.find("model");
  if (found == value.end() || found->is_null()) return std::nullopt;
  ModelVerdict model;
  model.verdict = named(string_of(*found, "verdict"), "verdict", Verdict::not_verified);
  if (!member(*found, "consistent").is_null()) model.consistent = boolean_of(*found, "consistent");
  model.asked = real_of(*found, "asked");
  model.seen = real_of(*found, "seen");
  model.U = real_of(*found, "U");
  if (const auto said = found->find("objection"); said != found->end() && !said->is_null())
    model.objection = string_of(*found, "objection");
  return model;
}

// Of a program that knew of no limits: none.
std::vector<JudgedLimit> limits_of(const Json& value, Motion& motion) {
  std::vector<JudgedLimit> limits;
  if (!value.contains("limits")) return limits;
  for (const Json& entry : array_of(value, "limits")) {
    JudgedLimit& limit = limits.emplace_back();
    limit.element = integer(member(entry, "element"), "element");
    limit.kind = named(string_of(entry, "coefficient"), "coefficient", CoefficientKind::damping);
    limit.bounds = {member(entry, "low").is_null() ? -INFINITY : real_of(entry, "low"),
                    member(entry, "high").is_null() ? INFINITY : real_of(entry, "high")};
    limit.verdict = named(string_of(entry, "verdict"), "verdict", LimitVerdict::violated);
    limit.reason = string_of(entry, "reason");
    const std::string unit = string_of(entry, "unit");
    if (unit == stiffness_unit(Motion::rotation) || unit == damping_unit(Motion::rotation)) motion = Motion::rotation;
  }
  return limits;
}

// Of a dwell that is stored, or of a service that does not tell: none.
std::optional<LiveAge> age_of(const Json& value) {
  if (!value.contains("stale")) return std::nullopt;
  return LiveAge{real_of(value, "estimate_age_s"), boolean_of(value, "stale")};
}

CoefficientMove move_of(const Json& value) {
  if (value.is_null()) return {};
  return {real_of(value, "change"), real_of(value, "U95"), boolean_of(value, "moved")};
}

// Of a dwell that is not measured now, or of a service that does not tell: none.
std::optional<SinceBefore> since_of(const Json& value) {
  const auto found = value.find("since");
  if (found == value.end() || found->is_null()) return std::nullopt;
  SinceBefore since{integer(member(*found, "index"), "index"), string_of(*found, "start_utc"),
                    real_of(*found, "end_s")};
  for (const Json& element : array_of(*found, "elements"))
    since.elements.push_back({integer(member(element, "k"), "k"), move_of(member(element, "stiffness")),
                              move_of(member(element, "damping"))});
  return since;
}

// A line of `warnings` that is no doubt. told: its entry of `warned`; null: of a program that told the text alone. Then
// only the kind that is treated in another way is recognized.
Warning warning_of(const std::string& text, const Json* told) {
  if (told == nullptr)
    return {text.starts_with(kNotSettled) ? WarningKind::not_settled : WarningKind::other, text, {}, {}};
  Warning warning{named(string_of(*told, "kind"), "kind", WarningKind::any_motion), text, {}, {}};
  for (const Json& k : array_of(*told, "elements")) warning.elements.push_back(integer(k, "elements"));
  warning.channels = strings_of(*told, "channels");
  return warning;
}

// The doubts come first among the warnings, repeated for whoever reads only these.
std::vector<Warning> warnings_of(const Json& value, std::size_t doubts) {
  const std::vector<std::string> texts = strings_of(value, "warnings");
  if (texts.size() < doubts) fail("warnings", "the doubts, repeated");
  const Json* const told = value.contains("warned") ? &array_of(value, "warned") : nullptr;
  if (told != nullptr && told->size() != texts.size()) fail("warned", "one entry for each of the warnings");
  std::vector<Warning> warnings;
  for (std::size_t i = doubts; i < texts.size(); ++i)
    warnings.push_back(warning_of(texts[i], told != nullptr ? &(*told)[i] : nullptr));
  return warnings;
}

DwellView parse(const Json& value) {
  DwellView view;
  Dwell& d = view.dwell;
  if (const Json& index = member(value, "index"); !index.is_null()) d.index = integer(index, "index");
  d.state = named(string_of(value, "state"), "state", State::fault);
  if (d.state == State::complete) d.ended_by = named(string_of(value, "ended_by"), "ended_by", EndedBy::rearmed);
  d.start_s = real_of(value, "start_s");
  d.settled_s = real_of(value, "settled_s");
  d.verdict_s = real_of(value, "verdict_s");
  d.end_s = real_of(value, "end_s");
  d.memory_time_s = real_of(value, "memory_time_s");
  d.memory_time_predicted_s = real_of(value, "memory_time_predicted_s");
  d.settles_in_s = real_of(value, "settles_in_s");
  d.settling_reason = string_of(value, "settling_reason");
  d.frequency_hz = estimate(member(value, "frequency_hz"));
  d.t_ref_s = real_of(value, "t_ref_s");
  view.run = {string_of(value, "rig_sha256"), string_of(value, "version"), string_of(value, "start_utc")};
  for (const Json& p : array_of(value, "phasors")) {
    view.channels.push_back({string_of(p, "channel"), string_of(p, "unit")});
    d.phasors.push_back(phasor(p));
  }
  for (const Json& e : array_of(value, "elements")) d.elements.push_back(element(e, view.motion));
  for (const Json& row : array_of(value, "covariance")) {
    if (!row.is_array()) fail("covariance", "an array of arrays");
    for (const Json& entry : row) d.covariance.push_back(real(entry, "covariance"));
  }
  for (const Json& entry : array_of(value, "doubts")) {
    Doubt& doubt = d.doubts.emplace_back();
    for (const Json& k : array_of(entry, "elements")) doubt.elements.push_back(integer(k, "elements"));
    doubt.what = string_of(entry, "what");
  }
  d.warnings = warnings_of(value, d.doubts.size());
  d.unstated = strings_of(value, "unstated");
  view.transient = motion_of(value);
  view.model = model_of(value);
  view.limits = limits_of(value, view.motion);
  for (JudgedLimit& limit : view.limits)
    limit.doubted = limit.verdict == LimitVerdict::none && doubt_of(d, limit.element) != nullptr;
  view.age = age_of(value);
  view.since = since_of(value);
  return view;
}

}  // namespace

tl::expected<DwellView, std::string> dwell_from_json(const Json& value) {
  try {
    return parse(value);
  } catch (const Mistake& mistake) {
    return tl::unexpected("dwell object: " + std::string(mistake.what()));
  }
}

tl::expected<DwellView, std::string> parse_dwell(std::string_view text) {
  const Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) return tl::unexpected(std::string("not JSON"));
  return dwell_from_json(value);
}

}  // namespace dwell
