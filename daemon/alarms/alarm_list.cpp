#include "daemon/alarms/alarm_list.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

namespace dwell {
namespace {

bool is_active(AlarmState state) { return state == AlarmState::unacknowledged || state == AlarmState::acknowledged; }

// The order in which operators read them.
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

// A trouble found by this call and by the last one has lasted for the time between them. The time of an unknown one
// stands still. Any other has faded.
void AlarmList::weigh(const std::vector<Trouble>& troubles, const std::vector<Trouble>& unknown, std::int64_t raw_ns) {
  const std::int64_t passed_ns = lasting_.empty() ? 0 : raw_ns - looked_ns_;
  looked_ns_ = raw_ns;
  std::set<std::string_view> present;
  for (const Trouble& trouble : troubles) {
    present.insert(trouble.name);
    lasting_.emplace(trouble.name, Lasting{0, raw_ns, false});
  }
  std::set<std::string_view> stands_still;
  for (const Trouble& trouble : unknown) stands_still.insert(trouble.name);
  for (auto at = lasting_.begin(); at != lasting_.end();) {
    Lasting& lasting = at->second;
    if (stands_still.count(at->first) > 0) {
      lasting.present = false;
      lasting.seen_ns += passed_ns;
      ++at;
      continue;
    }
    const bool was_present = std::exchange(lasting.present, present.count(at->first) > 0);
    const std::int64_t change_ns = was_present && lasting.present ? passed_ns : -passed_ns / kFade;
    lasting.lasted_ns = std::clamp(lasting.lasted_ns + change_ns, std::int64_t{0}, kLasts_ns);
    if (lasting.present) lasting.seen_ns = raw_ns;
    const bool forgotten = !lasting.present && lasting.lasted_ns == 0 && raw_ns - lasting.seen_ns >= kGone_ns;
    at = forgotten ? lasting_.erase(at) : std::next(at);
  }
}

std::vector<AlarmChange> AlarmList::follow(const std::vector<Trouble>& troubles, const std::vector<Trouble>& unknown,
                                           const record::ClockPair& now) {
  std::vector<AlarmChange> told;
  std::set<std::string_view> known;
  weigh(troubles, unknown, now.raw_ns);
  left_out_ = 0;
  for (const Trouble& trouble : troubles) {
    if (!known.insert(trouble.name).second) continue;  // two of one name: the first counts
    const auto alarm = alarms_.find(trouble.name);
    if (alarm != alarms_.end() && is_active(alarm->second.state)) {
      alarm->second.text = trouble.text;
    } else if (lasting_.at(trouble.name).lasted_ns >= kLasts_ns) {
      if (auto raised = raise(trouble, now)) told.push_back(std::move(*raised));
    }
  }
  for (const Trouble& trouble : unknown)
    if (const auto alarm = alarms_.find(trouble.name); alarm != alarms_.end() && is_active(alarm->second.state))
      alarm->second.text = trouble.text;
  for (auto at = alarms_.begin(); at != alarms_.end();) {
    Alarm& alarm = at->second;
    const AlarmState before = alarm.state;
    const auto lasting = lasting_.find(at->first);
    const bool gone = lasting == lasting_.end() || now.raw_ns - lasting->second.seen_ns >= kGone_ns;
    if (is_active(before) && gone) {
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
