#include "daemon/ctl/run_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "config/rig_file.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"

namespace dwell::ctl {
namespace {

using record::Result;
using record::RunReader;

// Most bytes of each text of an event, on the page and with --json. Those of the service have some 200; a hostile file
// may hold 8 MB in each.
constexpr std::size_t kEventBytes = 4000;

tl::unexpected<std::string> fail(std::string why) { return tl::unexpected(std::move(why)); }

std::uint64_t size_of(const std::string& file) {
  std::error_code missing;
  const auto bytes = std::filesystem::file_size(file, missing);
  return missing ? 0 : bytes;
}

RunSummary headline_of(const std::string& file, const RunReader& reader) {
  RunSummary run;
  run.file = file;
  run.bytes = size_of(file) + size_of(file + "-wal");
  run.header = reader.header();
  run.end = reader.end();
  run.span_s = reader.span_s();
  run.ended_utc = reader.ended_utc();
  return run;
}

Json json_or_text(const std::string& text) {
  Json value = Json::parse(text, nullptr, false);
  return value.is_discarded() ? Json(text) : value;
}

std::string printed(const char* pattern, double value) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

}  // namespace

Result<RunSummary> read_summary(const std::string& file) {
  auto reader = RunReader::open(file);
  if (!reader) return fail(reader.error());
  RunSummary run = headline_of(file, *reader);
  if (const auto rig = config::parse(run.header.rig.text, run.header.rig.path, {})) run.rig = rig->rig.name;
  const auto key = record::PublicKey::parse(run.header.vkey);
  run.key = key ? key->fingerprint() : "not readable: " + key.error();
  std::string unreadable;
  const auto results = reader->dwells([&](const record::StoredResult& result) {
    auto view = dwell_from_json(Json::parse(result.dwell, nullptr, false));
    if (view && (result.final || view->dwell.index))
      run.dwells.push_back(std::move(*view));
    else if (!view)
      unreadable = file + ": the result at position " + std::to_string(result.position) + ": " + view.error();
    return unreadable.empty();
  });
  if (!results) return fail(results.error());
  if (!unreadable.empty()) return fail(unreadable);
  const auto events = reader->events([&](const record::StoredEvent& event) {
    run.events.push_back(event);
    record::shorten(run.events.back(), kEventBytes);
    return true;
  });
  if (!events) return fail(events.error());
  const auto models = reader->models([&](const record::StoredModel& model) {
    run.models.push_back(model);
    return true;
  });
  if (!models) return fail(models.error());
  std::stable_sort(run.models.begin(), run.models.end(),
                   [](const record::StoredModel& a, const record::StoredModel& b) { return a.position < b.position; });
  auto signatures = reader->signatures();
  if (!signatures) return fail(signatures.error());
  run.signatures = std::move(*signatures);
  return run;
}

const char* state_of(const RunSummary& run) noexcept { return run.end ? "closed" : "open"; }

Json summary_json(const RunSummary& run) {
  Json dwells = Json::array();
  for (const DwellView& view : run.dwells) dwells.push_back(json_value(view));
  Json events = Json::array();
  for (const record::StoredEvent& event : run.events) events.push_back(json_or_text(to_json(event)));
  Json models = Json::array();
  for (const record::StoredModel& model : run.models) {
    Json entry = json_or_text(to_json(model));
    if (entry.is_object()) entry["kind"] = model.kind;
    models.push_back(std::move(entry));
  }
  Json signatures = Json::array();
  for (const record::PersonalSignature& signature : run.signatures)
    signatures.push_back(json_or_text(to_json(signature)));
  return {{"file", run.file},
          {"bytes", run.bytes},
          {"state", state_of(run)},
          {"rig", run.rig.empty() ? Json(nullptr) : Json(run.rig)},
          {"key", run.key},
          {"span_s", run.span_s ? json_number(*run.span_s) : Json(nullptr)},
          {"ended", run.ended_utc.empty() ? Json(nullptr) : Json(run.ended_utc)},
          {"header", json_or_text(to_json(run.header))},
          {"end", run.end ? json_or_text(to_json(*run.end)) : Json(nullptr)},
          {"dwells", std::move(dwells)},
          {"models", std::move(models)},
          {"events", std::move(events)},
          {"signatures", std::move(signatures)}};
}

std::string bytes_text(double bytes) {
  constexpr std::array<const char*, 5> kUnits{"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  for (; bytes >= 999.5 && unit + 1 < kUnits.size(); ++unit) bytes /= 1000.0;
  return printed(unit == 0 || bytes >= 99.95 ? "%.0f " : bytes >= 9.995 ? "%.1f " : "%.2f ", bytes) + kUnits[unit];
}

std::string duration_text(double seconds) {
  if (seconds < 119.95) return printed("%.1f s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 7200) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

}  // namespace dwell::ctl
