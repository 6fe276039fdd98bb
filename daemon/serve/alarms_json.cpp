#include "daemon/serve/alarms_json.hpp"

#include <utility>

#include "daemon/alarms/alarm_list.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"

namespace dwell {

HttpReply alarms_answer(const ServiceView& view) {
  static const AlarmList kNone;
  const AlarmList& list = view.alarms != nullptr ? *view.alarms : kNone;
  Json alarms = Json::array();
  for (const Alarm& alarm : list.alarms())
    alarms.push_back({{"name", alarm.name},
                      {"text", alarm.text},
                      {"state", to_string(alarm.state)},
                      {"since", record::iso_utc(alarm.since_utc_ns)},
                      {"changed", record::iso_utc(alarm.changed_utc_ns)},
                      {"count", alarm.count},
                      {"acknowledged_by", json_text(alarm.acknowledged_by)},
                      {"comment", json_text(alarm.comment)}});
  return {200, dump(Json{{"unacknowledged", list.unacknowledged()},
                         {"left_out", list.left_out()},
                         {"alarms", std::move(alarms)}})};
}

}  // namespace dwell
