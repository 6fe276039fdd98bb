#include "daemon/alarms/alarms.hpp"

#include <utility>

namespace dwell {
namespace {

record::StoredEvent event_of(const char* what, const AlarmChange& change, std::string text) {
  record::StoredEvent event;
  event.what = what;
  event.text = std::move(text);
  event.before = to_string(change.before);
  event.after = to_string(change.alarm.state);
  return event;
}

std::string times(const Alarm& alarm) {
  return alarm.count > 1 ? ", raised " + std::to_string(alarm.count) + " times" : "";
}

}  // namespace

void Alarms::tell(const AlarmChange& change) {
  const Alarm& alarm = change.alarm;
  std::string text = "alarm " + alarm.name;
  if (alarm.state == AlarmState::unacknowledged) {
    text += ": " + alarm.text;
    log_.warning(text);
  } else {
    text += alarm.state == AlarmState::returned ? " has returned, not acknowledged" : " has returned" + times(alarm);
    log_.info(text);
  }
  store_(event_of("alarm", change, std::move(text)));
}

void Alarms::look(const Health& health, const record::ClockPair& now) {
  for (const AlarmChange& change : list_.follow(health.troubles, health.unknown, now)) tell(change);
}

tl::expected<void, std::string> Alarms::acknowledge(const std::string& name, const std::string& comment,
                                                    const record::Person& by, const record::ClockPair& now) {
  const std::string person = record::who(by);
  const auto done = list_.acknowledge(name, person, comment, now);
  if (!done) return tl::unexpected(done.error());
  record::StoredEvent event =
      event_of("action", *done, "alarm " + name + " acknowledged by " + person + times(done->alarm));
  event.person = by;
  event.comment = comment;
  log_.info(event.text + (comment.empty() ? "" : ": " + comment));
  store_(std::move(event));
  return {};
}

}  // namespace dwell
