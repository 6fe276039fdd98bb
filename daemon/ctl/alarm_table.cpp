#include "daemon/ctl/alarm_table.hpp"

#include <utility>

#include "daemon/ctl/json_member.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell::ctl {
namespace {

// "2026-11-23T12:03:17.250000Z" to the second, as people write it.
std::string time_text(const std::string& iso) {
  std::string text = iso.substr(0, 19);
  if (text.size() == 19) text[10] = ' ';
  return text;
}

bool waits(const ListedAlarm& alarm) { return alarm.state != "acknowledged"; }

std::string more_text(const AlarmsList& list) {
  return std::to_string(list.left_out) + " more found no room in the list";
}

}  // namespace

std::optional<AlarmsList> alarms_from_json(const Json& value) {
  const auto found = value.is_object() ? value.find("alarms") : value.end();
  if (found == value.end() || !found->is_array()) return std::nullopt;
  AlarmsList list;
  list.unacknowledged = count_member(value, "unacknowledged");
  list.left_out = count_member(value, "left_out");
  for (const Json& item : *found)
    list.alarms.push_back({text_member(item, "name"), text_member(item, "text"), text_member(item, "state"),
                           text_member(item, "since"), text_member(item, "acknowledged_by"),
                           count_member(item, "count")});
  return list;
}

std::string alarms_table(const AlarmsList& list) {
  if (list.alarms.empty()) return "no alarms\n";
  std::vector<std::string> names, states, since, counts, by, texts;
  for (const ListedAlarm& alarm : list.alarms) {
    names.push_back(alarm.name);
    states.push_back(alarm.state);
    since.push_back(time_text(alarm.since));
    counts.push_back(alarm.count > 0 ? std::to_string(alarm.count) : kNoNumber);
    by.push_back(alarm.by.empty() ? kNoNumber : alarm.by);
    texts.push_back(alarm.text);
  }
  Table table;
  table.add("alarm", std::move(names));
  table.add("state", std::move(states));
  table.add("since (UTC)", std::move(since));
  table.add("count", std::move(counts), Align::right);
  table.add("acknowledged by", std::move(by));
  table.add("", std::move(texts));
  return table.text() + (list.left_out > 0 ? more_text(list) + "\n" : "");
}

Section alarms_section(const AlarmsList& list, std::size_t columns) {
  Section section;
  if (list.alarms.empty()) return section;
  section.name = kAlarms;
  section.head.push_back({"alarms", Style::title});
  const auto add = [&](const std::string& text, Style style) {
    for (std::string& line : wrapped(printable(text), columns, 2)) section.body.push_back({std::move(line), style});
  };
  for (const ListedAlarm& alarm : list.alarms) {
    std::string text = alarm.state + ": " + alarm.name;
    if (alarm.count > 1) text += ", " + std::to_string(alarm.count) + " times";
    text += ", since " + time_text(alarm.since) + " UTC: " + alarm.text;
    if (!alarm.by.empty()) text += " (" + alarm.by + ")";
    add(text, waits(alarm) && alarm.state != kReturned ? Style::alarm : Style::plain);
  }
  if (list.left_out > 0) add(more_text(list), Style::alarm);
  return section;
}

}  // namespace dwell::ctl
