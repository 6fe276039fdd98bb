#include "daemon/ctl/watch_state.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/ctl/json_member.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::ctl {
namespace {

// Whether there are data that ought to move on: while idle, or where the drive is not seen, there are none. Those of a
// dwell that has ended do not: its numbers are a result, see WatchState::ended().
bool has_data(const Dwell& dwell) { return dwell.state == State::settling || dwell.state == State::measuring; }

// Whether the dwell that came holds other data than the one before.
bool moved(const Dwell& before, const Dwell& after) {
  return before.index != after.index || before.state != after.state || !(before.end_s == after.end_s);
}

}  // namespace

std::vector<ChannelState> channel_states(const Json& list) {
  std::vector<ChannelState> channels;
  if (!list.is_array()) return channels;
  for (const Json& item : list) {
    ChannelState channel;
    channel.name = text_member(item, "name");
    if (text_member(item, "status") != "ok" || !text_member(item, "reason").empty())
      channel.status = text_member(item, "text");
    channel.age_s = number_member(item, "age_s");
    channels.push_back(std::move(channel));
  }
  return channels;
}

WhyUnverified why_unverified(const Json& verification) {
  WhyUnverified why;
  const Json* const dwell = member_of(verification, "dwell");
  if (dwell != nullptr && dwell->is_number_integer()) why.dwell = dwell->get<int>();
  const Json* const reasons = member_of(verification, "reasons");
  if (reasons != nullptr && reasons->is_array() && !reasons->empty() && reasons->front().is_string())
    why.reason = reasons->front().get<std::string>();
  return why;
}

std::string run_text(const Json& health) {
  const Json* const recorder = member_of(health, "recorder");
  const Json* const going_on = recorder != nullptr ? member_of(*recorder, "run") : nullptr;
  if (going_on != nullptr && going_on->is_object()) {
    const std::string label = text_member(*going_on, "label");
    return "run " + integer_text(*going_on, "run") + (label.empty() ? "" : ", “" + label + "”");
  }
  const Json* const run = member_of(health, "run");
  const Json* const recorded = run != nullptr ? member_of(*run, "recorded") : nullptr;
  if (recorded == nullptr || !recorded->is_boolean()) return {};
  return recorded->get<bool>() ? "no run goes on" : "not recorded";
}

Played played(const Json& health) {
  const Json* const devices = member_of(health, "devices");
  if (devices == nullptr || !devices->is_array()) return Played::none;
  const auto says = [](const Json& device, const char* name) {
    const Json* const value = member_of(device, name);
    return value != nullptr && value->is_boolean() && value->get<bool>();
  };
  if (std::none_of(devices->begin(), devices->end(), [&](const Json& d) { return says(d, "recorded"); }))
    return Played::none;
  const bool ended = std::all_of(devices->begin(), devices->end(), [&](const Json& d) { return says(d, "ended"); });
  return ended ? Played::to_its_end : Played::going_on;
}

std::optional<std::int64_t> state_since(const Json& events, State state) {
  const Json* const list = member_of(events, "events");
  if (list == nullptr || !list->is_array()) return std::nullopt;
  for (auto event = list->rbegin(); event != list->rend(); ++event) {
    const std::string began = text_member(*event, "state");
    if (began.empty()) continue;  // it tells of no change of state
    const auto utc_ns = record::parse_utc(text_member(*event, "utc"));
    return began == to_string(state) && utc_ns ? std::optional(*utc_ns) : std::nullopt;
  }
  return std::nullopt;
}

void Renewals::moved(double now_s) noexcept {
  std::rotate(turn_s_, turn_s_ + 2, turn_s_ + 3);
  turn_s_[0] = std::isfinite(moved_s_) ? now_s - moved_s_ : 0.0;
  moved_s_ = now_s;
}

// One outage among three renewals must not pass as usual: the shortest counts.
double Renewals::old_after_s() const noexcept {
  return std::max(kOldAfter_s, kOldAfterUpdates * *std::min_element(turn_s_, turn_s_ + 3));
}

void WatchState::take(DwellView dwell, double now_s) {
  if (!dwell_ || !has_data(dwell.dwell) || moved(dwell_->dwell, dwell.dwell)) {
    // The service may have told the same for minutes before watch began.
    const double published_s = dwell.age && std::isfinite(dwell.age->s) ? now_s - dwell.age->s : now_s;
    renewals_.moved(published_s);
  }
  heard_s_ = now_s;
  renewals_.told(now_s);
  trend_.take(dwell, now_s);
  keep_verdicts(dwell);
  if (has_coefficients(dwell.dwell)) last_ = dwell;
  dwell_ = std::move(dwell);
}

void WatchState::keep_verdicts(DwellView& ended) const {
  if (ended.dwell.state != State::complete || !last_ || last_->dwell.index != ended.dwell.index ||
      last_->run.start_utc != ended.run.start_utc)
    return;
  for (JudgedLimit& limit : ended.limits) {
    const ElementEstimate* const now = element_of(ended.dwell, limit.element);
    const ElementEstimate* const then = element_of(last_->dwell, limit.element);
    const auto known = std::find_if(last_->limits.begin(), last_->limits.end(), [&](const JudgedLimit& l) {
      return l.element == limit.element && l.kind == limit.kind;
    });
    if (now == nullptr || then == nullptr || known == last_->limits.end()) continue;
    const bool stiffness = limit.kind == CoefficientKind::stiffness;
    const Coefficient &a = stiffness ? now->stiffness : now->damping, &b = stiffness ? then->stiffness : then->damping;
    if (a.value == b.value && a.U95 == b.U95) limit = *known;
  }
}

void WatchState::take(std::vector<ChannelState> channels, double now_s) {
  channels_ = {std::move(channels), now_s};
  heard_s_ = now_s;
}

void WatchState::take(AlarmsList alarms, double now_s) {
  alarms_ = {std::move(alarms), now_s};
  heard_s_ = now_s;
}

void WatchState::take_utc(std::int64_t utc_ns, double now_s) { utc_ns_ = {utc_ns, now_s}; }

void WatchState::take_gpio(std::string lines, double now_s) {
  gpio_ = {std::move(lines), now_s};
  heard_s_ = now_s;
}

bool WatchState::take_rig(std::string called, std::string sha256) {
  name = std::move(called);
  const bool another = !rig_.empty() && rig_ != sha256;
  rig_ = std::move(sha256);
  if (!another) return false;
  dwell_.reset();
  last_.reset();
  unverified_.reset();
  since_.reset();
  renewals_ = {};
  trend_ = {};
  return true;
}

double WatchState::age_s(double now_s) const { return now_s - renewals_.moved_s(); }

std::string WatchState::why_unverified() const {
  if (!dwell_ || !dwell_->model || dwell_->model->verdict != Verdict::not_verified || !unverified_) return {};
  // The doubts themselves stand above the numbers in full.
  if (!dwell_->dwell.doubts.empty()) return "the coefficients are doubted";
  if (unverified_->dwell && unverified_->dwell != dwell_->dwell.index) return "it is being verified";
  return unverified_->reason.empty() ? "no reason stated" : unverified_->reason;
}

std::optional<std::int64_t> WatchState::utc_ns(double now_s) const {
  if (!utc_ns_.value) return std::nullopt;
  return *utc_ns_.value + static_cast<std::int64_t>(1e9 * (now_s - utc_ns_.at_s));
}

std::optional<std::int64_t> WatchState::since_utc_ns() const {
  if (!dwell_) return std::nullopt;
  const Dwell& dwell = dwell_->dwell;
  const double t_s = dwell.state == State::settling    ? dwell.start_s
                     : dwell.state == State::measuring ? dwell.verdict_s
                     : dwell.state == State::complete  ? dwell.end_s
                                                       : kNaN;
  const auto start_ns = record::parse_utc(dwell_->run.start_utc);
  if (start_ns && std::isfinite(t_s)) return *start_ns + static_cast<std::int64_t>(1e9 * t_s);
  if (since_ && since_->first == dwell.state) return since_->second;
  return std::nullopt;
}

double WatchState::ago_s(const std::string& start_utc, double t_s, double now_s) const {
  const auto now_ns = utc_ns(now_s);
  const auto start_ns = record::parse_utc(start_utc);
  if (!now_ns || !start_ns) return kNaN;
  return 1e-9 * static_cast<double>(*now_ns - *start_ns) - t_s;
}

double WatchState::before_ago_s(double now_s) const {
  return dwell_ && dwell_->since ? ago_s(dwell_->since->start_utc, dwell_->since->end_s, now_s) : kNaN;
}

double WatchState::ended_ago_s(double now_s) const { return ended() ? data_ago_s(*dwell_, now_s) : kNaN; }

const DwellView* WatchState::last() const {
  const bool none = dwell_ && (dwell_->dwell.state == State::idle || dwell_->dwell.state == State::fault) &&
                    dwell_->dwell.elements.empty();
  return none && last_ ? &*last_ : nullptr;
}

void WatchState::take_last(DwellView dwell) {
  if (!has_coefficients(dwell.dwell)) return;
  last_ = std::move(dwell);
}

bool WatchState::old(double now_s) const { return !trouble.empty() || stale() || age_s(now_s) > old_after_s(); }

Silence WatchState::silence(double now_s) const {
  if (!trouble.empty() || silent(now_s)) return Silence::service;
  return stale() || now_s - renewals_.told_s() > old_after_s() ? Silence::estimation : Silence::data;
}

std::optional<ChannelState> WatchState::channel(const std::string& asked, double now_s) const {
  const auto found = std::find_if(channels_.value.begin(), channels_.value.end(),
                                  [&asked](const ChannelState& c) { return c.name == asked; });
  if (found == channels_.value.end()) return std::nullopt;
  ChannelState channel = *found;
  channel.age_s += channels_age_s(now_s);
  return channel;
}

}  // namespace dwell::ctl
