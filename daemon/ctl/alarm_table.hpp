// The service's alarms for people. Made from its JSON, which may hold anything.
//
// Bound to one thread, not real-time.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/report/line.hpp"

namespace dwell::ctl {

// Words as the service sends them; what it did not send is empty.
struct ListedAlarm {
  std::string name, text, state;
  std::string since;      // ISO 8601, UTC
  std::string by;         // who acknowledged it
  std::size_t count = 0;  // times raised; 0: not told
};
struct AlarmsList {
  std::size_t unacknowledged = 0;
  std::size_t left_out = 0;         // found no room in the service's list
  std::vector<ListedAlarm> alarms;  // in the service's order: those that nobody has acknowledged first
};

// The state of an alarm that is over and that nobody has acknowledged.
inline constexpr std::string_view kReturned = "returned-unacknowledged";
// The name of the section.
inline constexpr std::string_view kAlarms = "alarms";

// value: the interface's object of alarms. nullopt: it is no list of alarms.
[[nodiscard]] std::optional<AlarmsList> alarms_from_json(const nlohmann::ordered_json& value);

// One line per alarm, the state in words; or that there is none.
[[nodiscard]] std::string alarms_table(const AlarmsList& list);
// The same for the screen of watch. Alarms that last and that nobody has acknowledged stand out. No alarms: empty.
[[nodiscard]] Section alarms_section(const AlarmsList& list, std::size_t columns);

}  // namespace dwell::ctl
