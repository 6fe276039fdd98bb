#include "daemon/serve/recorder_json.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <tuple>
#include <utility>

#include "daemon/record/utc_text.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/serve/api.hpp"
#include "daemon/serve/page_query.hpp"
#include "daemon/serve/query.hpp"

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

// Whether the name can stand in a path and in a header as it is.
bool is_plain_name(std::string_view name) {
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
           c == '-';
  });
}

bool goes_on(const ServiceView& view, const ListedRun& run) {
  return run.state == "recording" ||
         (view.recording.state && view.recording.state->recording && view.recording.state->run.file == run.file);
}

// nullptr: it has not been looked at.
const record::RunVerdict* verdict_on(const ServiceView& view, const ListedRun& run) {
  if (!view.recording.audits) return nullptr;
  const auto found = view.recording.audits->find(run.file);
  return found == view.recording.audits->end() ? nullptr : &found->second;
}

bool is_removed(const ServiceView& view, const ListedRun& run) {
  const record::RunVerdict* verdict = verdict_on(view, run);
  return verdict != nullptr && verdict->removed;
}

// Why the run's file cannot be downloaded; empty: it can.
std::string no_download(const ServiceView& view, const ListedRun& run) {
  if (is_removed(view, run)) return "its file was removed";
  if (goes_on(view, run)) return "the run goes on: its file is complete when the run has ended";
  if (run.state == "ending") return "the run has just ended: its file is being closed";
  if (run.state == "cut off")
    return "the run was cut off: a part of it may be in a -wal file; copy both files from the recording directory";
  if (run.state != "closed") return "its file cannot be read as a run; copy it from the recording directory";
  if (run.linked) return "its file is a link, and none is followed; copy it from where the link leads";
  if (!is_plain_name(run.file)) return "its name has unusual characters; copy it from the recording directory";
  return view.recording.state ? "" : "this service does not record";
}

// Where the dwells of the run's file are told; null: they are not, or there are none.
Json dwells_json(const ServiceView& view, const ListedRun& run) {
  if (run.dwells == 0 || !no_dwells(view, run).empty()) return nullptr;
  return std::string(kRunFiles) + percent_encoded(run.file) + "/dwells";
}

Json no_verdict(const char* state, const std::string& reason) {
  return {{"state", state},     {"where", nullptr}, {"until_s", nullptr},
          {"trusted", nullptr}, {"utc", nullptr},   {"reason", reason}};
}

// back: how many runs of the list are newer.
Json audit_json(const ServiceView& view, const ListedRun& run, std::size_t back) {
  if (goes_on(view, run)) return no_verdict("not audited", "the run goes on");
  if (run.state == "ending") return no_verdict("not audited", "the run has just ended: its file is being closed");
  const record::RunVerdict* known = verdict_on(view, run);
  if (known == nullptr) {
    if (back >= record::RunAudits::kAudited)
      return no_verdict("not audited", "only the newest " + std::to_string(record::RunAudits::kAudited) +
                                           " runs are audited by the service; run dwellctl audit");
    return no_verdict("waiting", "it waits for its turn");
  }
  const record::RunVerdict& verdict = *known;
  if (!verdict.why_none.empty()) return no_verdict("not audited", verdict.why_none);
  return {{"state", to_string(verdict.state)},
          {"where", json_text(verdict.where)},
          {"until_s", verdict.until_s ? json_number(*verdict.until_s) : Json(nullptr)},
          {"trusted", verdict.trusted},
          {"utc", json_text(verdict.utc)},
          {"reason", nullptr}};
}

// Where the next answer begins, for ?from=. Copies of a run have the same number: behind the first of them the number
// alone would lead back to it. next: not the first of the list.
Json next_json(ListedRuns::const_iterator next) {
  if (std::prev(next)->run != next->run) return next->run;
  return std::to_string(next->run) + ":" + percent_encoded(next->file);
}

}  // namespace

const ListedRun* run_of_dwells(const ServiceView& view) {
  // Recorder and estimation each read the clock, so their instants of one beginning differ by less than this. Two runs
  // never begin within it.
  constexpr std::int64_t kSameBegin_ns = 1'000'000'000;
  const auto begun_ns = record::parse_utc(view.run.start_utc);
  if (!begun_ns || !view.recording.state) return nullptr;
  const auto begun_then = [&begun_ns](const ListedRun& run) {
    const auto utc_ns = record::parse_utc(run.begun_utc);
    return utc_ns && std::abs(*utc_ns - *begun_ns) < kSameBegin_ns;
  };
  const record::RecorderState& state = *view.recording.state;
  if (state.recording && begun_then(state.run)) return &state.run;
  if (!view.recording.runs) return nullptr;
  const auto run = std::find_if(view.recording.runs->rbegin(), view.recording.runs->rend(), begun_then);
  return run == view.recording.runs->rend() ? nullptr : &*run;
}

std::string no_dwells(const ServiceView& view, const ListedRun& run) {
  if (is_removed(view, run)) return "its file was removed";
  if (goes_on(view, run)) return "the run goes on: /api/v1/dwells tells its dwells";
  if (run.linked) return "its file is a link, and none is followed";
  return view.recording.state ? "" : "this service does not record";
}

const ListedRun* listed_run(const ServiceView& view, std::string_view file) {
  if (!view.recording.runs) return nullptr;
  const ListedRuns& all = *view.recording.runs;
  const auto run = std::find_if(all.begin(), all.end(), [&](const ListedRun& listed) { return listed.file == file; });
  return run == all.end() ? nullptr : &*run;
}

HttpReply run_file_answer(const ServiceView& view, std::string_view file) {
  const ListedRun* const run = listed_run(view, file);
  if (run == nullptr)
    return http_error(404, "there is no run of this name: expected /api/v1/runs/FILE, FILE as /api/v1/runs tells it");
  if (const std::string why = no_download(view, *run); !why.empty()) return http_error(409, why);
  HttpReply reply{200, {}, "application/vnd.sqlite3"};
  reply.file = view.recording.state->directory + "/" + run->file;
  reply.file_name = run->file;
  return reply;
}

Json recorder_json(const ServiceView& view) {
  if (!view.recording.state) return nullptr;
  const record::RecorderState& state = *view.recording.state;
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

// Oldest first: those from a run on, or the newest.
HttpReply runs_answer(const ServiceView& view, std::string_view query) {
  const auto page = page_of(query, kRunsPerAnswer, {"RUN", false, true});
  if (!page) return http_error(400, page.error());
  static const ListedRuns kNone;
  const ListedRuns& all = view.recording.runs ? *view.recording.runs : kNone;
  const auto count = static_cast<std::ptrdiff_t>(std::min(page->count, all.size()));
  auto first = all.end() - count;
  if (page->from)
    first = std::find_if(all.begin(), all.end(), [&](const ListedRun& run) {
      return std::tie(run.run, run.file) >= std::make_tuple(std::int64_t{*page->from}, page->from_file);
    });
  const auto last = first + std::min(count, all.end() - first);
  Json runs = Json::array();
  for (auto run = first; run != last; ++run) {
    const bool recorded =
        view.recording.state && view.recording.state->recording && view.recording.state->run.file == run->file;
    Json object = run_json(recorded ? view.recording.state->run : *run);
    if (is_removed(view, *run)) object["state"] = "removed";
    const std::string why = no_download(view, *run);
    object["download"] = why.empty() ? Json(std::string(kRunFiles) + run->file) : Json(nullptr);
    object["no_download"] = json_text(why);
    object["dwells_at"] = dwells_json(view, *run);
    object["audit"] = audit_json(view, *run, static_cast<std::size_t>(all.end() - run) - 1);
    runs.push_back(std::move(object));
  }
  return {200, dump(Json{{"rig", view.rig.name},
                         {"total", all.size()},
                         {"next", last == all.end() ? Json(nullptr) : next_json(last)},
                         {"runs", std::move(runs)}})};
}

}  // namespace dwell
