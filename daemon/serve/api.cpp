#include "daemon/serve/api.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "daemon/calibration.hpp"
#include "daemon/freshness.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_brief.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/verification_json.hpp"
#include "daemon/serve/alarms_json.hpp"
#include "daemon/serve/channel_status.hpp"
#include "daemon/serve/element_standing.hpp"
#include "daemon/serve/events_json.hpp"
#include "daemon/serve/metrics.hpp"
#include "daemon/serve/page_query.hpp"
#include "daemon/serve/query.hpp"
#include "daemon/serve/recorder_json.hpp"
#include "daemon/serve/traces_json.hpp"

namespace dwell {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// Why it does not deliver, or what is wrong with what it delivers.
Json reason_of(const ChannelView& channel) {
  const std::string& reason = channel.fault != Fault::none ? channel.reason : channel.condition_reason;
  return reason.empty() ? Json(nullptr) : Json(reason);
}

const char* measured_by(const Channel& channel) {
  switch (channel.measures) {
    case Quantity::displacement:
      return "displacement";
    case Quantity::velocity:
      return "velocity";
    case Quantity::acceleration:
      return "acceleration";
    case Quantity::force:
      return "force";
    case Quantity::auxiliary:
      break;
  }
  return "auxiliary";
}

// null: the figure is NaN, or the estimate is stale, so that nobody knows whether it is still true.
Json unless_stale(const ServiceView& view, double figure) { return is_stale(view) ? Json(nullptr) : number(figure); }

// As the rig file names it.
Json place(int at) { return at == kGround ? Json("ground") : Json(at); }

// A channel's calibration, as the rig file states it; null: it states none.
Json calibration_json(const ServiceView& view, const Channel& channel) {
  if (channel.calibration.id.empty()) return nullptr;
  const auto overdue = calibration_overdue(channel, view.clock_synchronized ? view.now_utc_ns : 0);
  return {{"id", channel.calibration.id},
          {"due", json_text(channel.calibration.due)},
          {"overdue", overdue ? Json(*overdue) : Json(nullptr)}};
}

Json channels_json(const ServiceView& view) {
  Json list = Json::array();
  for (std::size_t i = 0; i < view.snapshot.channels.size(); ++i) {
    const ChannelView& channel = view.snapshot.channels[i];
    const Tally& tally = channel.tally;
    const auto& relative_to = view.rig.channels[i].relative_to;
    list.push_back({{"name", view.rig.channels[i].name},
                    {"value", number(channel.value)},
                    {"unit", view.rig.channels[i].unit},
                    {"measures", measured_by(view.rig.channels[i])},
                    {"at", place(view.rig.channels[i].at)},
                    {"relative_to", relative_to ? place(*relative_to) : Json(nullptr)},
                    {"status", status_of(channel)},
                    {"reason", reason_of(channel)},
                    {"text", status_text(channel)},
                    {"age_s", number(reading_age_s(channel, view.now_ns))},
                    {"rate_hz", unless_stale(view, delivered_rate_hz(channel))},
                    {"clock", channel.clock.kind == Clock::device ? "device" : "host"},
                    {"clock_rate_hz", number(channel.clock.rate_hz)},
                    {"jitter_s", unless_stale(view, delivered_jitter_s(channel))},
                    {"drift_ppm", number(channel.clock.drift_ppm)},
                    {"lost", channel.clock.lost},
                    {"received", tally.received},
                    {"used", tally.used},
                    {"dropped", tally.dropped()},
                    {"queued", tally.queued},
                    {"gaps", channel.gaps},
                    {"calibration", calibration_json(view, view.rig.channels[i])},
                    {"dropped_by",
                     {{"refused", tally.refused},
                      {"late", tally.late},
                      {"ahead", tally.ahead},
                      {"overflow", tally.overflow},
                      {"rejected", tally.rejected}}}});
  }
  return list;
}

Json stale_json(const ServiceView& view) {
  Json list = Json::array();
  for (std::size_t i = 0; i < view.snapshot.channels.size(); ++i)
    if (view.snapshot.channels[i].fault != Fault::none) list.push_back(view.rig.channels[i].name);
  return list;
}

Json devices_json(const ServiceView& view) {
  Json list = Json::array();
  for (const DeviceView& device : view.snapshot.devices) {
    Json faults = Json::object();
    for (int kind = 1; kind < kFaultCount; ++kind)
      if (const auto count = device.faults[static_cast<std::size_t>(kind)]; count > 0)
        faults[to_string(static_cast<Fault>(kind))] = count;
    list.push_back({{"name", device.name},
                    {"driver", device.driver},
                    {"recorded", device.recorded},
                    {"up", device.up},
                    {"ended", device.ended},
                    {"faults", std::move(faults)},
                    {"foreign", device.foreign}});
  }
  return list;
}

// The configured lines by what they are for.
Json gpio_json(const ServiceView& view) {
  Json lines = Json::object();
  for (std::size_t i = 0; i < gpio::kFunctions; ++i) {
    const gpio::LineStatus& line = view.gpio[i];
    if (!line.configured) continue;
    lines[gpio::kFunctionNames[i]] = {{"works", line.works},
                                      {"reason", line.reason.empty() ? Json(nullptr) : Json(line.reason)},
                                      {"level", line.level ? Json(*line.level ? 1 : 0) : Json(nullptr)},
                                      {"edges", line.edges},
                                      {"bounces", line.bounces},
                                      {"lost", line.lost}};
  }
  return lines;
}

Json run_json(const ServiceView& view) {
  const RunView& run = view.snapshot.run;
  return {{"recorded", run.bracketed},
          {"begun_by", run.bracketed && run.on ? Json(run.by_operator ? "operator" : "drive") : Json(nullptr)},
          {"held", run.held},
          {"text", view.health.run}};
}

Json troubles_json(const Health& health) {
  Json list = Json::array();
  for (const Trouble& trouble : health.troubles)
    list.push_back({{"name", trouble.name},
                    {"kind", to_string(trouble.kind)},
                    {"channel", json_text(trouble.channel)},
                    {"text", trouble.text},
                    {"why", json_text(trouble.why)},
                    {"degrades", trouble.degrades}});
  return list;
}

Json modbus_json(const ServiceView& view) {
  if (!view.clients.modbus) return nullptr;
  const ModbusStats& modbus = *view.clients.modbus;
  return {{"clients", modbus.clients},       {"answers", modbus.answers},
          {"exceptions", modbus.exceptions}, {"malformed", modbus.malformed},
          {"timed_out", modbus.timed_out},   {"refused", modbus.refused},
          {"displaced", modbus.displaced},   {"awaits_address", modbus.awaits_address}};
}

Json health_json(const ServiceView& view) {
  const Health& health = view.health;
  const Json stale = stale_json(view);
  Json threads = Json::array();
  for (const WatchedThread& thread : view.threads) {
    threads.push_back({{"name", thread.name},
                       {"turned_s_ago", number(static_cast<double>(thread.still_ns(view.now_ns)) * 1e-9)},
                       {"ok", thread.turns(view.now_ns)}});
  }
  return {{"status", to_string(health.status)},
          {"reason", health.status == Health::Status::ok ? Json(nullptr) : Json(reason_of(health))},
          {"troubles", troubles_json(health)},
          {"ready", health.ready},
          {"run", run_json(view)},
          {"state", to_string(view.snapshot.dwell.state)},
          {"rig", view.rig.name},
          {"rig_sha256", view.run.rig_sha256},
          {"version", view.run.version},
          {"utc", view.now_utc_ns == 0 ? Json(nullptr) : Json(record::iso_utc(view.now_utc_ns))},
          {"uptime_s", number(view.uptime_s)},
          {"old_after_s", kOldAfter_s},
          {"old_after_updates", kOldAfterUpdates},
          {"stale", stale},
          {"devices", devices_json(view)},
          {"gpio", gpio_json(view)},
          {"threads", std::move(threads)},
          {"skipped_turns", view.snapshot.skipped_turns},
          {"http",
           {{"clients", view.clients.http.clients},
            {"streams", view.clients.http.streams},
            {"requests", view.clients.http.requests},
            {"refused", view.clients.http.refused},
            {"displaced", view.clients.http.displaced},
            {"wrong_tokens", view.clients.wrong_tokens},
            {"events_dropped", view.clients.http.events_dropped},
            {"awaits_address", view.clients.http.awaits_address}}},
          {"modbus", modbus_json(view)},
          {"log", {{"lines", view.log.lines}, {"dropped", view.log.dropped}, {"failing", view.log.failing}}},
          {"recorder", recorder_json(view)}};
}

// Of the run whose dwells are told; null: it is not recorded.
Json file_of_dwells(const ServiceView& view) {
  const record::ListedRun* const run = run_of_dwells(view);
  return run == nullptr ? Json(nullptr) : Json(run->file);
}

const FinishedDwells& finished(const ServiceView& view) {
  static const FinishedDwells kNone;
  return view.snapshot.finished ? *view.snapshot.finished : kNone;
}

// Oldest first: those from an index on, or the newest; as many as one answer may hold.
HttpReply dwells_answer(const ServiceView& view, std::string_view query) {
  const auto page = page_of(query, kDwellsPerAnswer, {"INDEX", true});
  if (!page) return http_error(400, page.error());
  const FinishedDwells& all = finished(view);
  std::vector<std::string> texts;
  std::size_t bytes = 0;
  const auto take = [&](const Dwell& dwell) {
    const DwellView finished = finished_dwell(view, dwell);
    std::string text = page->brief ? dump(brief_json(finished, view.rig)) : to_json(finished);
    if (texts.size() == page->count || (!texts.empty() && bytes + text.size() > kBytesOfDwells)) return false;
    bytes += text.size();
    texts.push_back(std::move(text));
    return true;
  };
  std::optional<int> next;
  if (page->from) {
    auto dwell =
        std::find_if(all.begin(), all.end(), [&](const auto& d) { return d->index.value_or(0) >= *page->from; });
    while (dwell != all.end() && take(**dwell)) ++dwell;
    if (dwell != all.end()) next = (*dwell)->index;
  } else {
    for (auto dwell = all.rbegin(); dwell != all.rend() && take(**dwell);) ++dwell;
    std::reverse(texts.begin(), texts.end());
  }
  HttpReply reply;
  reply.body = "{\"rig\":" + dump(view.rig.name) +
               ",\"total\":" + std::to_string(all.size() + view.snapshot.forgotten) +
               ",\"forgotten\":" + std::to_string(view.snapshot.forgotten) + ",\"file\":" + dump(file_of_dwells(view)) +
               ",\"next\":" + (next ? std::to_string(*next) : "null") + ",\"dwells\":[";
  for (std::size_t i = 0; i < texts.size(); ++i) (reply.body += i > 0 ? "," : "") += texts[i];
  reply.body += "]}";
  return reply;
}

// One dwell by its index: as it ended, or else the current one. A dwell that has ended may still be the current one.
HttpReply dwell_answer(const ServiceView& view, std::string_view index_text) {
  const auto index = integer_of(index_text);
  if (!index || *index < 1)
    return http_error(404, "expected /api/v1/dwells/INDEX, the index of a dwell: a number from 1");
  const FinishedDwells& all = finished(view);
  for (const auto& dwell : all)
    if (dwell->index == *index) return {200, to_json(finished_dwell(view, *dwell))};
  if (view.snapshot.dwell.index == *index) return {200, dwell_text_json(view)};
  const std::string which = "dwell " + std::to_string(*index);
  if (!all.empty() && *index < all.front()->index.value_or(0))
    return http_error(404, which + " is no longer kept; the oldest that is has the index " +
                               std::to_string(all.front()->index.value_or(0)));
  return http_error(404, which + " has not been measured");
}

// The newest verification of the run, or why there is none.
HttpReply verification_answer(const ServiceView& view) {
  if (const auto& newest = view.snapshot.verified)
    return {200, dump(json_value(newest->verification, view.rig, newest->dwell))};
  Verification none;
  none.accuracy = view.verification.accuracy;
  none.reasons = {"no dwell of this run has settled yet: a model is verified on the transient before its data"};
  if (std::isfinite(view.snapshot.dwell.settled_s))
    none.reasons = {"the dwell has just settled: its model is being verified"};
  if (!view.verification.live)
    none.reasons = {
        "the rig file asks for no verification by the service (live = false in [verification]); "
        "dwellctl verify does it for a recording"};
  return {200, dump(json_value(none, view.rig, {}))};
}

std::string control_error(std::string_view reason) { return dump(Json{{"error", reason}}); }

// Per channel what an operator wants to see before a run: does it deliver, how fast, and how well are its instants
// known.
std::string check_answer(const ServiceView& view) {
  Json list = Json::array();
  for (std::size_t i = 0; i < view.snapshot.channels.size(); ++i) {
    const ChannelView& channel = view.snapshot.channels[i];
    const int device = view.rig.channels[i].device;
    list.push_back(
        {{"name", view.rig.channels[i].name},
         {"device", device < 0 ? Json(nullptr) : Json(view.rig.devices[static_cast<std::size_t>(device)].name)},
         {"value", number(channel.value)},
         {"unit", view.rig.channels[i].unit},
         {"rate_hz", unless_stale(view, delivered_rate_hz(channel))},
         // The instant is known to half the device's turnaround.
         {"latency_s", channel.heard_ns < 0 ? Json(nullptr) : number(2.0 * channel.half_width_s)},
         {"age_s", number(reading_age_s(channel, view.now_ns))},
         {"status", status_of(channel)},
         {"reason", reason_of(channel)}});
  }
  return dump(Json{{"rig", view.rig.name}, {"channels", std::move(list)}});
}

// Of the paths that take no query.
HttpReply unasked_answer(const ServiceView& view, std::string_view path) {
  if (path == "/api/v1/dwell") return {200, dwell_text_json(view)};
  constexpr std::string_view kOne = "/api/v1/dwells/";
  if (path.substr(0, kOne.size()) == kOne) return dwell_answer(view, path.substr(kOne.size()));
  if (path == "/api/v1/channels") return {200, dump({{"channels", channels_json(view)}})};
  if (path == "/metrics") return {200, metrics_text(view), kExpositionType};
  if (path == "/api/v1/verification") return verification_answer(view);
  if (path == "/api/v1/alarms") return alarms_answer(view);
  if (path.substr(0, kRunFiles.size()) == kRunFiles) return run_file_answer(view, path.substr(kRunFiles.size()));
  if (path == "/api/v1/health")
    return {view.health.status == Health::Status::fault ? 503 : 200, dump(health_json(view))};
  return http_error(
      404,
      "nothing is served here; there are /api/v1/dwell, /api/v1/dwells, /api/v1/dwells/INDEX, "
      "/api/v1/channels, /api/v1/verification, /api/v1/runs, /api/v1/runs/FILE, /api/v1/runs/FILE/dwells, "
      "/api/v1/events, /api/v1/alarms, "
      "/api/v1/traces, /api/v1/health, /api/v1/rights, /api/v1/stream and /metrics");
}

}  // namespace

std::string dwell_text_json(const ServiceView& view) { return to_json(live_dwell(view)); }

HttpReply http_answer(const ServiceView& view, std::string_view path, std::string_view query) {
  if (path == "/api/v1/dwells") return dwells_answer(view, query);
  if (path == "/api/v1/events") return events_answer(view, query);
  if (path == "/api/v1/traces") return traces_answer(view, query);
  if (path == "/api/v1/runs") return runs_answer(view, query);
  HttpReply reply = unasked_answer(view, path);
  if (reply.status == 404) return reply;
  if (const auto fault = query_fault(query, {})) return http_error(400, *fault);
  return reply;
}

std::string control_answer(const ServiceView& view, std::string_view line, const Operate& operate) {
  const auto parsed = parse_request(line);
  if (!parsed) return control_error(parsed.error());
  const Json& request = *parsed;
  const auto verb = request.find("verb");
  if (verb == request.end() || !verb->is_string()) return control_error("no verb: expected {\"verb\":\"status\"}");
  const std::string& name = verb->get_ref<const std::string&>();
  if (name == "status") {
    std::string reply = "{\"health\":" + dump(health_json(view)) + ",\"dwell\":" + dwell_text_json(view) +
                        ",\"channels\":" + dump(channels_json(view)) + "}";
    return reply;
  }
  if (name == "check") return check_answer(view);
  if (is_operator_verb(name)) {
    const auto done = perform(name, request, operate);
    return done ? dump(Json{{"done", true}}) : control_error(done.error().reason);
  }
  return control_error("unknown verb \"" + name +
                       "\"; there are status, check, start, stop, label, rearm, acknowledge, sign and enter");
}

}  // namespace dwell
