// runs: the runs that the service has recorded, or those of a folder.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/fetch.hpp"
#include "daemon/ctl/json_member.hpp"
#include "daemon/ctl/progress.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/run_summary.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/record/words.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell::ctl {
namespace {

namespace fs = std::filesystem;

// As in the service's answer.
Json row_of(const record::ListedRun& run) {
  return {{"run", run.run},         {"file", run.file},
          {"label", run.label},     {"begun_by", run.begun_by},
          {"begun", run.begun_utc}, {"ended", run.ended_utc.empty() ? Json(nullptr) : Json(run.ended_utc)},
          {"state", run.state},     {"bytes", run.bytes},
          {"dwells", run.dwells},   {"kept", run.kept}};
}

// "2026-07-01 10:12:20", whole seconds: a row must fit beside others.
std::string instant(const std::string& utc) {
  const auto ns = record::parse_utc(utc);
  if (!ns) return utc.empty() ? kNoNumber : utc;
  std::string text = record::iso_utc(*ns).substr(0, 19);
  text[10] = ' ';
  return text;
}

std::string length(const std::string& begun, const std::string& ended) {
  const auto from_ns = record::parse_utc(begun);
  const auto to_ns = record::parse_utc(ended);
  return from_ns && to_ns ? duration_text(1e-9 * static_cast<double>(*to_ns - *from_ns)) : kNoNumber;
}

std::string runs_table(const Json& list) {
  std::vector<std::string> numbers, starts, lengths, states, dwells, sizes, labels, files;
  for (const Json& row : list) {
    numbers.push_back(integer_text(row, "run"));
    starts.push_back(instant(text_member(row, "begun")));
    lengths.push_back(length(text_member(row, "begun"), text_member(row, "ended")));
    states.push_back(text_member(row, "state"));
    dwells.push_back(integer_text(row, "dwells"));
    const double bytes = number_member(row, "bytes");
    sizes.push_back(std::isfinite(bytes) ? bytes_text(bytes) : kNoNumber);
    labels.push_back(clipped(printable(text_member(row, "label")), record::kLabelBytes));
    files.push_back(text_member(row, "file"));
  }
  Table table;
  table.add("run", std::move(numbers), Align::right);
  table.add("began (UTC)", std::move(starts));
  table.add("lasted", std::move(lengths), Align::right);
  table.add("state", std::move(states));
  table.add("dwells", std::move(dwells), Align::right);
  table.add("size", std::move(sizes), Align::right);
  table.add("label", std::move(labels));
  table.add("file", std::move(files));
  return table.text();
}

int print(const Json& document, bool json) {
  const Json& list = document.at("runs");
  const std::string text = json           ? dump(document, 2) + "\n"
                           : list.empty() ? std::string("no run has been recorded\n")
                                          : runs_table(list);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kDone;
}

int runs_in(const std::string& directory, bool json) {
  std::error_code failed;
  std::vector<std::string> names;
  for (fs::directory_iterator it(directory, failed), end; !failed && it != end; it.increment(failed))
    if (it->path().extension() == ".dwell") names.push_back(it->path().filename().string());
  if (failed) {
    tell_error(directory + ": " + failed.message());
    return kUsage;
  }
  record::ListedRuns found;
  ProgressBar bar("reading");
  for (const std::string& name : names) {
    bar.show(static_cast<double>(found.size()) / static_cast<double>(names.size()));
    found.push_back(record::look_at_run(directory, name));
  }
  std::sort(found.begin(), found.end(), [](const record::ListedRun& a, const record::ListedRun& b) {
    return std::tie(a.run, a.begun_utc, a.file) < std::tie(b.run, b.begun_utc, b.file);
  });
  Json list = Json::array();
  for (const record::ListedRun& run : found) list.push_back(row_of(run));
  return print(Json{{"runs", std::move(list)}}, json);
}

}  // namespace

int runs(const Service& service, const std::string& directory) {
  if (!directory.empty()) return runs_in(directory, service.json);
  const auto value = fetch(service, "/api/v1/runs");
  if (!value) return value.error();
  const auto list = value->is_object() ? value->find("runs") : value->end();
  if (list == value->end() || !list->is_array()) return not_the_service(service.url, "no runs");
  return print(*value, service.json);
}

}  // namespace dwell::ctl
