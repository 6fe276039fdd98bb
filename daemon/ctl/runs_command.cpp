// runs: the runs that the service has recorded, or those of a folder.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/fetch.hpp"
#include "daemon/ctl/progress.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/run_summary.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/table.hpp"

namespace dwell::ctl {
namespace {

namespace fs = std::filesystem;

// As in the service's answer.
Json row_of(const RunSummary& run) {
  return {{"run", run.header.run > 0 ? Json(run.header.run) : Json(nullptr)},
          {"id", run.header.id},
          {"file", run.file},
          {"label", run.header.label},
          {"start_utc", run.header.start_utc},
          {"span_s", run.span_s ? json_number(*run.span_s) : Json(nullptr)},
          {"state", state_of(run)},
          {"why", run.end ? Json(run.end->why) : Json(nullptr)},
          {"samples", run.end ? Json(run.end->samples) : Json(nullptr)},
          {"bytes", run.bytes}};
}

std::string text_of(const Json& row, const char* name) {
  const auto it = row.is_object() ? row.find(name) : row.end();
  return it != row.end() && it->is_string() ? it->get<std::string>() : "";
}

double number_of(const Json& row, const char* name) {
  const auto it = row.is_object() ? row.find(name) : row.end();
  return it != row.end() && it->is_number() ? it->get<double>() : kNaN;
}

std::string count_of(const Json& row, const char* name) {
  const auto it = row.is_object() ? row.find(name) : row.end();
  return it != row.end() && it->is_number_integer() ? it->dump() : kNoNumber;
}

std::string runs_table(const Json& list) {
  std::vector<std::string> numbers, starts, spans, states, samples, sizes, labels, files;
  for (const Json& row : list) {
    numbers.push_back(count_of(row, "run"));
    starts.push_back(text_of(row, "start_utc"));
    const double span_s = number_of(row, "span_s");
    spans.push_back(std::isfinite(span_s) ? duration_text(span_s) : kNoNumber);
    states.push_back(text_of(row, "state"));
    samples.push_back(count_of(row, "samples"));
    const double bytes = number_of(row, "bytes");
    sizes.push_back(std::isfinite(bytes) ? bytes_text(bytes) : kNoNumber);
    labels.push_back(text_of(row, "label"));
    files.push_back(text_of(row, "file"));
  }
  Table table;
  table.add("run", std::move(numbers), Align::right);
  table.add("began", std::move(starts));
  table.add("lasted", std::move(spans), Align::right);
  table.add("state", std::move(states));
  table.add("samples", std::move(samples), Align::right);
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
  std::vector<std::string> files;
  for (fs::directory_iterator it(directory, failed), end; !failed && it != end; it.increment(failed))
    if (it->path().extension() == ".dwell") files.push_back(it->path().string());
  if (failed) {
    tell_error(directory + ": " + failed.message());
    return kUsage;
  }
  std::vector<RunSummary> found;
  int code = kDone;
  ProgressBar bar("reading");
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto run = read_headline(files[i]);
    if (run) {
      found.push_back(std::move(*run));
    } else {
      tell_error(run.error());
      code = kUsage;
    }
    bar.show(static_cast<double>(i + 1) / static_cast<double>(files.size()));
  }
  std::sort(found.begin(), found.end(), [](const RunSummary& a, const RunSummary& b) {
    return std::tie(a.header.run, a.header.start_utc, a.file) < std::tie(b.header.run, b.header.start_utc, b.file);
  });
  Json list = Json::array();
  for (const RunSummary& run : found) list.push_back(row_of(run));
  (void)print(Json{{"runs", std::move(list)}}, json);
  return code;
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
