#include "daemon/alarms/alarm_list.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace dwell {
namespace {

bool is_active(AlarmState state) { return state == AlarmState::unacknowledged || state == AlarmState::acknowledged; }

// In the order in which operators read them.
int rank(AlarmState state) { return state == AlarmState::unacknowledged ? 0 : state == AlarmState::returned ? 1 : 2; }

void change(Alarm& alarm, AlarmInput input, const record::ClockPair& now) {
  alarm.state = next(alarm.state, input);
  alarm.changed_utc_ns = now.utc_ns;
}

}  // namespace

const char* to_string(AlarmState state) noexcept {
  switch (state) {
    case AlarmState::normal:
      return "normal";
    case AlarmState::unacknowledged:
      return "unacknowledged";
    case AlarmState::acknowledged:
      return "acknowledged";
    case AlarmState::returned:
      return "returned-unacknowledged";
  }
  return "unknown";
}

AlarmState next(AlarmState state, AlarmInput input) noexcept {
  switch (input) {
    case AlarmInput::lasts:
      return is_active(state) ? state : AlarmState::unacknowledged;
    case AlarmInput::gone:
      return state == AlarmState::unacknowledged ? AlarmState::returned
             : state == AlarmState::acknowledged ? AlarmState::normal
                                                 : state;
    case AlarmInput::acknowledge:
      return state == AlarmState::unacknowledged ? AlarmState::acknowledged
             : state == AlarmState::returned     ? AlarmState::normal
                                                 : state;
  }
  return state;
}

std::optional<AlarmChange> AlarmList::raise(const Trouble& trouble, const record::ClockPair& now) {
  if (alarms_.count(trouble.name) == 0 && alarms_.size() >= kMost) {
    ++left_out_;
    return std::nullopt;
  }
  Alarm& alarm = alarms_[trouble.name];
  const AlarmState before = alarm.state;
  change(alarm, AlarmInput::lasts, now);
  if (before == AlarmState::normal) alarm.since_utc_ns = now.utc_ns;
  alarm.name = trouble.name;
  alarm.text = trouble.text;
  ++alarm.count;
  if (before != AlarmState::normal) return std::nullopt;
  return AlarmChange{before, alarm};
}

std::vector<AlarmChange> AlarmList::follow(const std::vector<Trouble>& troubles, const record::ClockPair& now) {
  std::vector<AlarmChange> told;
  std::map<std::string, std::int64_t> wrong;
  left_out_ = 0;
  for (const Trouble& trouble : troubles) {
    const auto known = wrong_.find(trouble.name);
    const std::int64_t since_ns = known == wrong_.end() ? now.raw_ns : known->second;
    if (!wrong.emplace(trouble.name, since_ns).second) continue;  // two of one name: the first counts
    const auto alarm = alarms_.find(trouble.name);
    if (alarm != alarms_.end() && is_active(alarm->second.state)) {
      alarm->second.text = trouble.text;
    } else if (now.raw_ns - since_ns >= kLasts_ns) {
      if (auto raised = raise(trouble, now)) told.push_back(std::move(*raised));
    }
  }
  wrong_ = std::move(wrong);
  for (auto at = alarms_.begin(); at != alarms_.end();) {
    Alarm& alarm = at->second;
    const AlarmState before = alarm.state;
    if (is_active(before) && wrong_.count(at->first) == 0) {
      change(alarm, AlarmInput::gone, now);
      if (alarm.count == 1 || alarm.state == AlarmState::normal) told.push_back({before, alarm});
    }
    at = alarm.state == AlarmState::normal ? alarms_.erase(at) : std::next(at);
  }
  return told;
}

tl::expected<AlarmChange, std::string> AlarmList::acknowledge(const std::string& name, const std::string& by,
                                                              const std::string& comment,
                                                              const record::ClockPair& now) {
  const auto found = alarms_.find(name);
  if (found == alarms_.end()) return tl::unexpected("no alarm \"" + name + "\": expected one of the list of alarms");
  Alarm& alarm = found->second;
  if (alarm.state == AlarmState::acknowledged)
    return tl::unexpected("alarm " + name + " has been acknowledged already, by " + alarm.acknowledged_by);
  const AlarmState before = alarm.state;
  change(alarm, AlarmInput::acknowledge, now);
  alarm.acknowledged_by = by;
  alarm.comment = comment;
  AlarmChange done{before, alarm};
  if (alarm.state == AlarmState::normal) alarms_.erase(found);
  return done;
}

std::vector<Alarm> AlarmList::alarms() const {
  std::vector<Alarm> list;
  list.reserve(alarms_.size());
  for (const auto& [name, alarm] : alarms_) list.push_back(alarm);
  std::stable_sort(list.begin(), list.end(), [](const Alarm& a, const Alarm& b) {
    return std::make_tuple(rank(a.state), -a.changed_utc_ns) < std::make_tuple(rank(b.state), -b.changed_utc_ns);
  });
  return list;
}

std::size_t AlarmList::count(AlarmState state) const noexcept {
  return static_cast<std::size_t>(std::count_if(alarms_.begin(), alarms_.end(),
                                                [state](const auto& entry) { return entry.second.state == state; }));
}

std::size_t AlarmList::unacknowledged() const noexcept {
  return count(AlarmState::unacknowledged) + count(AlarmState::returned);
}

}  // namespace dwell
