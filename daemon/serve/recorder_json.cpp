#include "daemon/serve/recorder_json.hpp"

#include <algorithm>
#include <utility>

#include "daemon/report/json_parts.hpp"
#include "daemon/serve/api.hpp"
#include "daemon/serve/page_query.hpp"

namespace dwell {
namespace {

using record::ListedRun;
using record::ListedRuns;

Json run_json(const ListedRun& run) {
  return {{"run", run.run},
          {"file", run.file},
          {"label", run.label},
          {"begun_by", json_text(run.begun_by)},
          {"begun", json_text(run.begun_utc)},
          {"ended", json_text(run.ended_utc)},
          {"state", run.state},
          {"bytes", run.bytes},
          {"dwells", run.dwells},
          {"kept", run.kept}};
}

}  // namespace

Json recorder_json(const ServiceView& view) {
  if (!view.recorder) return nullptr;
  const record::RecorderState& state = *view.recorder;
  Json alarms = Json::array();
  for (const record::RecorderAlarm& alarm : state.alarms) alarms.push_back(alarm.text);
  const double since_commit_s = static_cast<double>(view.now_ns - state.committed_ns) * 1e-9;
  return {{"recording", state.recording},
          {"reason", state.recording ? Json(nullptr) : json_text(state.why_not)},
          {"run", state.recording ? run_json(state.run) : Json(nullptr)},
          {"samples", state.recording ? Json(state.run.samples) : Json(nullptr)},
          {"since_commit_s", state.recording ? Json(std::max(0.0, since_commit_s)) : Json(nullptr)},
          {"buffer_fill", state.buffer_fill},
          {"buffer_records", state.buffer_records},
          {"lost_records", state.lost_records},
          {"lost_results", state.lost_results},
          {"lost_events", state.lost_events},
          {"alarms", std::move(alarms)}};
}

// Oldest first: those from a run's number on, or the newest.
HttpReply runs_answer(const ServiceView& view, std::string_view query) {
  const auto page = page_of(query, kRunsPerAnswer);
  if (!page)
    return http_error(400, "the query is not understood: expected from=RUN, count=1 to " +
                               std::to_string(kRunsPerAnswer) + ", or both joined by &");
  static const ListedRuns kNone;
  const ListedRuns& all = view.runs ? *view.runs : kNone;
  const auto count = static_cast<std::ptrdiff_t>(std::min(page->count, all.size()));
  auto first = all.end() - count;
  if (page->from) first = std::find_if(all.begin(), all.end(), [&](const auto& r) { return r.run >= *page->from; });
  const auto last = first + std::min(count, all.end() - first);
  Json runs = Json::array();
  for (auto run = first; run != last; ++run) {
    const bool goes_on = view.recorder && view.recorder->recording && view.recorder->run.file == run->file;
    runs.push_back(run_json(goes_on ? view.recorder->run : *run));
  }
  return {200, dump(Json{{"rig", view.rig.name},
                         {"total", all.size()},
                         {"next", last == all.end() ? Json(nullptr) : Json(last->run)},
                         {"runs", std::move(runs)}})};
}

}  // namespace dwell
