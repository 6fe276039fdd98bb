// status, channels, dwells, alarms, verify: one question over HTTP, one answer on the screen.
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "daemon/ctl/alarm_table.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/fetch.hpp"
#include "daemon/ctl/http_client.hpp"
#include "daemon/ctl/tables.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/verification_json.hpp"
#include "daemon/report/verification_text.hpp"

namespace dwell::ctl {
namespace {

void print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

const Json* array_in(const Json& value, const char* name) {
  const auto it = value.is_object() ? value.find(name) : value.end();
  return it != value.end() && it->is_array() ? &*it : nullptr;
}

}  // namespace

int status(const Service& service) {
  const auto url = usable_url(service);
  if (!url) return url.error();
  const auto value = fetch(service, *url, "/api/v1/dwell");
  if (!value) return value.error();
  const auto view = dwell_from_json(*value);
  if (!view) return not_the_service(service.url, view.error());
  if (service.json) {
    print(dump(*value, 2) + "\n");
  } else {
    print(dwell_text(*view));
    // A service too old to tell, or one that has just ended, says nothing of its lines.
    if (const auto answer = http_get(*url, "/api/v1/health")) {
      const Json health = Json::parse(answer->body, nullptr, false);
      print(recording_text(health) + gpio_text(health));
    }
  }
  return view->dwell.state == State::measuring && view->dwell.doubts.empty() ? kDone : kNo;
}

int channels(const Service& service) {
  const auto value = fetch(service, "/api/v1/channels");
  if (!value) return value.error();
  const Json* list = array_in(*value, "channels");
  if (list == nullptr) return not_the_service(service.url, "no channels");
  print(service.json ? dump(*value, 2) + "\n" : channels_table(*list));
  return kDone;
}

int dwells(const Service& service) {
  const auto value = fetch(service, "/api/v1/dwells");
  if (!value) return value.error();
  const Json* list = array_in(*value, "dwells");
  if (list == nullptr) return not_the_service(service.url, "no dwells");
  if (service.json) {
    print(dump(*value, 2) + "\n");
    return kDone;
  }
  std::vector<DwellView> views;
  for (const Json& item : *list) {
    auto view = dwell_from_json(item);
    if (!view) return not_the_service(service.url, view.error());
    views.push_back(std::move(*view));
  }
  print(views.empty() ? "no dwell of this run has been completed\n" : dwells_table(views));
  const auto total = value->find("total");
  if (total != value->end() && total->is_number_unsigned() && total->get<std::size_t>() > views.size()) {
    print("the last " + std::to_string(views.size()) + " of " + total->dump() + "\n");
  }
  // The service tells the dwells of its current run alone: after a restart, and with each run, the list begins anew.
  if (const auto url = usable_url(service))
    if (const auto runs = http_get(*url, "/api/v1/runs"))
      print(earlier_runs_text(Json::parse(runs->body, nullptr, false)));
  return kDone;
}

int alarms(const Service& service) {
  const auto value = fetch(service, "/api/v1/alarms");
  if (!value) return value.error();
  const auto list = alarms_from_json(*value);
  if (!list) return not_the_service(service.url, "no alarms");
  print(service.json ? dump(*value, 2) + "\n" : alarms_table(*list));
  return list->alarms.empty() ? kDone : kNo;
}

int verify(const Service& service) {
  const auto value = fetch(service, "/api/v1/verification");
  if (!value) return value.error();
  const auto view = verification_from_json(*value);
  if (!view) return not_the_service(service.url, view.error());
  print(service.json ? dump(*value, 2) + "\n" : verification_text(*view));
  return view->verification.verdict == Verdict::adequate ? kDone : kNo;
}

}  // namespace dwell::ctl
