#include "daemon/serve/metrics.hpp"

#include <algorithm>
#include <array>

#include "daemon/alarms/alarm_list.hpp"

namespace dwell {
namespace {

void write_recorder(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_recorder_recording", "1: a run is being recorded.");
  out.sample(now.recording.state && now.recording.state->recording ? 1.0 : 0.0);
  if (!now.recording.state) return;
  const record::RecorderState& recorder = *now.recording.state;
  out.gauge("dwell_recorder_alarms", "Reasons why runs are not recorded as they should be.");
  out.sample(count_value(recorder.alarms.size()));
  out.gauge("dwell_recorder_buffer_fill_ratio", "Part of the recorder's buffer that is full.");
  out.sample(recorder.buffer_fill);
  if (recorder.recording) {
    out.gauge("dwell_recorder_commit_age_seconds", "Since the last commit of the run that is recorded.");
    out.sample(std::max(0.0, static_cast<double>(now.now_ns - recorder.committed_ns) * 1e-9));
  }
  out.counter("dwell_recorder_lost_records_total", "Records of the stream that were not recorded.");
  out.sample(count_value(recorder.lost_records));
  out.counter("dwell_recorder_lost_results_total", "Results that were not recorded.");
  out.sample(count_value(recorder.lost_results));
  out.counter("dwell_recorder_lost_events_total", "Events that were not recorded.");
  out.sample(count_value(recorder.lost_events));
}

void write_alarms(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_alarms", "Alarms by their state. The names: /api/v1/alarms.");
  for (const AlarmState state : {AlarmState::unacknowledged, AlarmState::acknowledged, AlarmState::returned})
    out.sample(now.alarms == nullptr ? 0.0 : count_value(now.alarms->count(state)), {{"state", to_string(state)}});
}

void write_http(const HttpStats& http, std::uint64_t wrong_tokens, Exposition& out) {
  out.gauge("dwell_http_clients", "Connections to the HTTP server.");
  out.sample(count_value(http.clients));
  out.gauge("dwell_http_streams", "Live streams among the connections.");
  out.sample(count_value(http.streams));
  out.counter("dwell_http_requests_total", "Requests to the HTTP server.");
  out.sample(count_value(http.requests));
  out.counter("dwell_http_refused_connections_total", "Connections refused because there were too many.");
  out.sample(count_value(http.refused));
  out.counter("dwell_http_displaced_connections_total", "Silent connections closed to make room for new ones.");
  out.sample(count_value(http.displaced));
  out.counter("dwell_http_dropped_events_total", "Events of live streams dropped because their reader was slow.");
  out.sample(count_value(http.events_dropped));
  out.counter("dwell_http_wrong_tokens_total", "Requests that showed a wrong token.");
  out.sample(count_value(wrong_tokens));
}

void write_modbus(const ModbusStats& modbus, Exposition& out) {
  out.gauge("dwell_modbus_clients", "Connections to the Modbus server.");
  out.sample(count_value(modbus.clients));
  out.counter("dwell_modbus_answers_total", "Requests to the Modbus server that were answered with registers.");
  out.sample(count_value(modbus.answers));
  out.counter("dwell_modbus_exceptions_total", "Requests to the Modbus server that were answered with an exception.");
  out.sample(count_value(modbus.exceptions));
  const std::pair<const char*, std::uint64_t> causes[] = {{"malformed", modbus.malformed},
                                                          {"timed out", modbus.timed_out},
                                                          {"displaced", modbus.displaced},
                                                          {"refused", modbus.refused}};
  out.counter("dwell_modbus_closed_connections_total", "Connections that the Modbus server closed, by the cause.");
  for (const auto& [cause, count] : causes) out.sample(count_value(count), {{"cause", cause}});
}

}  // namespace

void write_service_metrics(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_build_info", "1 beside the version of the service.");
  out.sample(1.0, {{"version", now.run.version}});
  out.gauge("dwell_rig_info", "1 beside the rig's name and the SHA-256 of its rig file.");
  out.sample(1.0, {{"rig", now.rig.name}, {"sha256", now.run.rig_sha256}});
  out.gauge("dwell_uptime_seconds", "Since the service began.");
  out.sample(now.uptime_s);
  constexpr std::array kStatuses{Health::Status::ok, Health::Status::degraded, Health::Status::fault};
  out.gauge("dwell_health", "Whether all is well: 1 for what holds. The reasons: /api/v1/health.");
  write_states(out, "status", now.health.status, kStatuses);
  out.gauge("dwell_thread_up", "1: the thread turns as it should.");
  for (const WatchedThread& thread : now.threads)
    out.sample(thread.turns(now.now_ns) ? 1.0 : 0.0, {{"thread", thread.name}});
  out.counter("dwell_estimate_skipped_turns_total", "Turns of the estimation that came too late and were left out.");
  out.sample(count_value(now.snapshot.skipped_turns));
  write_alarms(now, out);
  write_recorder(now, out);
  write_http(now.clients.http, now.clients.wrong_tokens, out);
  if (now.clients.modbus) write_modbus(*now.clients.modbus, out);
  out.counter("dwell_log_lines_total", "Lines handed to the log.");
  out.sample(count_value(now.log.lines));
  out.counter("dwell_log_dropped_lines_total", "Lines that the log did not write.");
  out.sample(count_value(now.log.dropped));
}

std::string metrics_text(const ServiceView& now) {
  Exposition out;
  write_measurement_metrics(now, out);
  write_intake_metrics(now, out);
  write_service_metrics(now, out);
  return out.text();
}

}  // namespace dwell
