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

std::uint64_t bytes_on_disk(const std::string& file) {
  std::error_code missing;
  const auto bytes = std::filesystem::file_size(file, missing);
  return missing ? 0 : bytes;
}

RunSummary headline_of(const std::string& file, const RunReader& reader) {
  RunSummary run;
  run.file = file;
  run.bytes = bytes_on_disk(file) + bytes_on_disk(file + "-wal");
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

// Room for the entries of one list.
class Room {
 public:
  // Whether an entry of this size still fits. Once one did not, none does: the list ends there.
  [[nodiscard]] bool take(std::size_t bytes) noexcept {
    left_ = bytes <= left_ ? left_ - bytes : 0;
    full_ = full_ || left_ == 0;
    return !full_;
  }

 private:
  std::size_t left_ = RunSummary::kListBytes;
  bool full_ = false;
};

void note_unreadable(RunSummary& run, std::string why) {
  constexpr std::size_t kMost = 1000;  // bytes: a hostile file may put megabytes into a message
  if (why.size() > kMost) why = why.substr(0, kMost) + " …";
  if (run.unreadable.size() < RunSummary::kUnreadable) {
    run.unreadable.push_back(std::move(why));
  } else {
    ++run.left_out.unreadable;
  }
}

// Reading a list ends at an entry that is damaged; the other lists are read all the same.
void note_end(RunSummary& run, const char* list, const Result<void>& read) {
  if (!read) note_unreadable(run, std::string(list) + " end early: " + read.error());
}

void read_dwells(RunReader& reader, RunSummary& run) {
  Room room;
  note_end(run, "dwells", reader.dwells([&](const record::StoredResult& result) {
    if (!room.take(sizeof(DwellView) + result.dwell.size())) {
      run.left_out.dwells += result.final ? 1 : 0;
      return true;
    }
    auto view = dwell_from_json(Json::parse(result.dwell, nullptr, false));
    if (!view) {
      note_unreadable(run,
                      run.file + ": the result at position " + std::to_string(result.position) + ": " + view.error());
    } else if (result.final || view->dwell.index) {
      run.dwells.push_back(std::move(*view));
    }
    return true;
  }));
}

std::size_t size_of(const record::StoredEvent& event) {
  std::size_t bytes = sizeof event;
  for (const std::string* text : {&event.utc, &event.what, &event.text, &event.before, &event.after, &event.comment})
    bytes += text->size();
  return bytes;
}

void read_events(RunReader& reader, RunSummary& run) {
  Room room;
  note_end(run, "events", reader.events([&](const record::StoredEvent& stored) {
    record::StoredEvent event = stored;
    record::shorten(event, kEventBytes);
    if (room.take(size_of(event))) {
      run.events.push_back(std::move(event));
    } else {
      ++run.left_out.events;
    }
    return true;
  }));
  record::sort_by_place(run.events);
}

void read_models(RunReader& reader, RunSummary& run) {
  Room room;
  note_end(run, "estimates and verifications", reader.models([&](const record::StoredModel& model) {
    if (room.take(sizeof model + model.from.size() + model.result.size())) {
      run.models.push_back(model);
    } else {
      ++run.left_out.models;
    }
    return true;
  }));
  std::stable_sort(run.models.begin(), run.models.end(),
                   [](const record::StoredModel& a, const record::StoredModel& b) { return a.position < b.position; });
}

// A JSON text as it stands within another, its lines indented.
std::string indented(const std::string& text, std::size_t columns) {
  std::string out;
  out.reserve(text.size() + text.size() / 4);
  for (const char c : text) {
    out += c;
    if (c == '\n') out.append(columns, ' ');  // JSON texts hold no line break within a string
  }
  return out;
}

// A member that is a list, behind another member of the document.
template <class Entry, class ToJson>
void write_list(const char* name, const std::vector<Entry>& entries, const ToJson& to_value,
                const std::function<void(const std::string&)>& write) {
  write(std::string(",\n  \"") + name + "\": [");
  const char* before = "\n    ";
  for (const Entry& entry : entries) {
    write(before + indented(dump(to_value(entry), 2), 4));
    before = ",\n    ";
  }
  write(entries.empty() ? "]" : "\n  ]");
}

}  // namespace

Result<RunSummary> read_summary(const std::string& file) {
  auto reader = RunReader::open(file);
  if (!reader) return fail(reader.error());
  RunSummary run = headline_of(file, *reader);
  if (const auto rig = config::parse(run.header.rig.text, run.header.rig.path, {})) run.rig = rig->rig.name;
  const auto key = record::PublicKey::parse(run.header.vkey);
  run.key = key ? key->fingerprint() : "not readable: " + key.error();
  read_dwells(*reader, run);
  read_events(*reader, run);
  read_models(*reader, run);
  auto signatures = reader->signatures();
  if (signatures) {
    run.signatures = std::move(*signatures);
  } else {
    note_unreadable(run, "no signature is shown: " + signatures.error());
  }
  return run;
}

const char* state_of(const RunSummary& run) noexcept { return run.end ? "closed" : "open"; }

void write_summary_json(const RunSummary& run, const std::function<void(const std::string&)>& write) {
  const RunSummary::LeftOut& left_out = run.left_out;
  const Json front = {{"file", run.file},
                      {"bytes", run.bytes},
                      {"state", state_of(run)},
                      {"rig", run.rig.empty() ? Json(nullptr) : Json(run.rig)},
                      {"key", run.key},
                      {"span_s", run.span_s ? json_number(*run.span_s) : Json(nullptr)},
                      {"ended", run.ended_utc.empty() ? Json(nullptr) : Json(run.ended_utc)},
                      {"unreadable", run.unreadable},
                      {"left_out",
                       {{"dwells", left_out.dwells},
                        {"models", left_out.models},
                        {"events", left_out.events},
                        {"unreadable", left_out.unreadable}}},
                      {"header", json_or_text(to_json(run.header))},
                      {"end", run.end ? json_or_text(to_json(*run.end)) : Json(nullptr)}};
  const std::string text = dump(front, 2);
  write(text.substr(0, text.rfind('\n')));  // the closing brace comes behind the lists
  write_list(
      "dwells", run.dwells, [](const DwellView& view) { return json_value(view); }, write);
  const auto model_value = [](const record::StoredModel& model) {
    Json entry = json_or_text(to_json(model));
    if (entry.is_object()) entry["kind"] = model.kind;
    return entry;
  };
  write_list("models", run.models, model_value, write);
  const auto stored = [](const auto& entry) { return json_or_text(to_json(entry)); };
  write_list("events", run.events, stored, write);
  write_list("signatures", run.signatures, stored, write);
  write("\n}\n");
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
