#include "daemon/serve/run_dwells.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/file_identity.hpp"
#include "daemon/record/result_text.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/snapshot.hpp"
#include "daemon/report/dwell_brief.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/objection_json.hpp"
#include "daemon/report/verification_json.hpp"
#include "daemon/serve/api.hpp"
#include "daemon/serve/page_query.hpp"
#include "daemon/serve/query.hpp"
#include "daemon/serve/recorder_json.hpp"

namespace dwell {
namespace {

using record::ChainReader;
using record::fails;
using record::Result;
using SteadyClock = std::chrono::steady_clock;

constexpr std::string_view kDwellsOfRun = "/dwells";

struct StoredDwell {
  int index = 0;
  std::int64_t seq = 0;  // of its entry
  std::string brief;     // JSON
};

// The newest verdict on each dwell's model, by the dwell's index. If these are too many or too long, those with the
// lowest indices are dropped.
class Verdicts {
 public:
  // change(ModelVerdict&).
  template <class Change>
  void change(int dwell, const Change& change) {
    ModelVerdict& verdict = verdicts_[dwell];
    bytes_ -= verdict.objection.size();
    change(verdict);
    bytes_ += verdict.objection.size();
    while (verdicts_.size() > 1 && (verdicts_.size() > RunDwells::kDwells || bytes_ > kBytesOfDwells)) {
      bytes_ -= verdicts_.begin()->second.objection.size();
      verdicts_.erase(verdicts_.begin());
    }
  }
  [[nodiscard]] std::optional<ModelVerdict> of(int dwell) const {
    const auto found = verdicts_.find(dwell);
    return found != verdicts_.end() ? std::optional(found->second) : std::nullopt;
  }

 private:
  std::map<int, ModelVerdict> verdicts_;
  std::size_t bytes_ = 0;  // of all objections
};

struct StoredRun {
  std::string path;
  record::FileIdentity identity{};
  std::int64_t number = 0;
  std::string rig;         // its name; empty: the rig file cannot be read
  std::string rig_sha256;  // of its file
  Verdicts models;
  std::deque<StoredDwell> dwells;  // the newest, oldest first
  std::size_t forgotten = 0;       // older ones
};

tl::unexpected<record::Failure> bad_entry(const record::Entry& entry, const std::string& what) {
  return fails("entry " + std::to_string(entry.seq) + ": " + what);
}

Result<DwellView> dwell_in(const record::Entry& entry, const Verdicts& models) {
  const auto result = record::parse_result(entry.body);
  if (!result) return bad_entry(entry, result.error());
  auto view = dwell_from_json(Json::parse(result->dwell, nullptr, false));
  if (!view) return bad_entry(entry, view.error());
  if (!view->dwell.index) return bad_entry(entry, "a dwell without an index");
  view->model = models.of(*view->dwell.index);
  return std::move(*view);
}

Result<void> take_model(const record::Entry& entry, Verdicts& models) {
  const auto stored = record::parse_model("verification", entry.body);
  if (!stored) return bad_entry(entry, stored.error());
  const auto view = verification_from_json(Json::parse(stored->result, nullptr, false));
  if (!view) return bad_entry(entry, view.error());
  if (view->dwell) models.change(*view->dwell, [&](ModelVerdict& of) { of = in_short(view->verification); });
  return {};
}

// What any motion held against a dwell when that had ended.
Result<void> take_objection(const record::Entry& entry, Verdicts& models) {
  const auto stored = record::parse_model("estimate", entry.body);
  if (!stored) return bad_entry(entry, stored.error());
  auto objection = objection_in(Json::parse(stored->result, nullptr, false));
  if (!objection) return bad_entry(entry, objection.error());
  if (*objection)
    models.change((*objection)->dwell, [&](ModelVerdict& of) { of.objection = std::move((*objection)->what); });
  return {};
}

// The time limit for reading one file.
struct Deadline {
  std::chrono::seconds after;
  SteadyClock::time_point at = SteadyClock::now() + after;
};

// Hands each entry of the kind to take(), in order, until the deadline.
template <class Take>
Result<void> each(ChainReader& chain, const char* kind, const Deadline& deadline, const Take& take) {
  chain.seek(1, kind);
  for (;;) {
    const auto row = chain.next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return {};
    if (SteadyClock::now() > deadline.at)
      return fails("reading it takes more than " + std::to_string(deadline.after.count()) + " s");
    if (auto taken = take((*row)->entry); !taken) return taken;
  }
}

Result<StoredRun> read_run(const std::string& path, std::chrono::seconds at_most) {
  const Deadline deadline{at_most};
  StoredRun run;
  run.path = path;
  run.identity = record::identity_of(path);
  Rig rig;
  {
    const auto reader = record::RunReader::open(path);
    if (!reader) return tl::unexpected(reader.error());
    const record::RunHeader& header = reader->header();
    run.number = header.run;
    if (auto file = config::parse(header.rig.text, header.rig.path, {})) rig = std::move(file->rig);
    run.rig = rig.name;
    run.rig_sha256 = header.rig.sha256;
  }
  auto chain = ChainReader::open(path, record::ChainSort::run);
  if (!chain) return tl::unexpected(chain.error());
  std::size_t bytes = 0;
  auto read = each(*chain, "verification", deadline, [&](const auto& entry) { return take_model(entry, run.models); });
  if (read)
    read = each(*chain, "estimate", deadline, [&](const auto& entry) { return take_objection(entry, run.models); });
  if (read) {
    read = each(*chain, "result", deadline, [&](const record::Entry& entry) -> Result<void> {
      if (const auto front = record::front_of(entry.body); front && !front->final) return {};
      const auto view = dwell_in(entry, run.models);
      if (!view) return tl::unexpected(view.error());
      if (view->dwell.state != State::complete) return {};
      StoredDwell dwell{*view->dwell.index, entry.seq, dump(brief_json(*view, rig))};
      bytes += dwell.brief.size();
      run.dwells.push_back(std::move(dwell));
      while (run.dwells.size() > 1 && (run.dwells.size() > RunDwells::kDwells || bytes > kBytesOfDwells)) {
        bytes -= run.dwells.front().brief.size();
        run.dwells.pop_front();
        ++run.forgotten;
      }
      return {};
    });
  }
  if (!read) return tl::unexpected(read.error());
  return run;
}

HttpReply list_answer(const StoredRun& run, const std::string& file, const Page& page) {
  auto first = run.dwells.end() - static_cast<std::ptrdiff_t>(std::min(page.count, run.dwells.size()));
  if (page.from)
    first = std::find_if(run.dwells.begin(), run.dwells.end(), [&](const auto& d) { return d.index >= *page.from; });
  const auto last = first + std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(page.count), run.dwells.end() - first);
  HttpReply reply;
  reply.body = "{\"rig\":" + dump(json_text(run.rig)) + ",\"rig_sha256\":" + dump(run.rig_sha256) +
               ",\"run\":" + std::to_string(run.number) + ",\"file\":" + dump(file) +
               ",\"total\":" + std::to_string(run.dwells.size() + run.forgotten) +
               ",\"forgotten\":" + std::to_string(run.forgotten) +
               ",\"next\":" + (last == run.dwells.end() ? "null" : std::to_string(last->index)) + ",\"dwells\":[";
  for (auto dwell = first; dwell != last; ++dwell) (reply.body += dwell == first ? "" : ",") += dwell->brief;
  reply.body += "]}";
  return reply;
}

Result<HttpReply> dwell_answer(const StoredRun& run, int index) {
  const auto stored =
      std::find_if(run.dwells.rbegin(), run.dwells.rend(), [&](const auto& d) { return d.index == index; });
  if (stored == run.dwells.rend())
    return http_error(404,
                      "no dwell of this run with the index " + std::to_string(index) + " has ended" +
                          (run.forgotten > 0 ? ", or it is not among the newest: dwellctl show FILE has all" : ""));
  auto chain = ChainReader::open(run.path, record::ChainSort::run);
  if (!chain) return tl::unexpected(chain.error());
  chain->seek(stored->seq, "result");
  const auto row = chain->next();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return fails(record::read_again());
  const auto view = dwell_in((*row)->entry, run.models);
  if (!view) return tl::unexpected(view.error());
  return HttpReply{200, to_json(*view)};
}

}  // namespace

// The runs read last. Bound to the thread that makes late answers.
class RunDwells::Reading {
 public:
  explicit Reading(std::chrono::seconds at_most) : at_most_(at_most) {}

  // make(run): Result<HttpReply>.
  template <class Make>
  HttpReply answer(const std::string& path, const std::string& file, const Make& make) {
    record::Failure why("");
    // A writer may have closed the file meanwhile: then the second reading succeeds.
    for (int tries = 0; tries < 2; ++tries) {
      Result<HttpReply> made = known(path).and_then([&](const StoredRun* run) { return make(*run); });
      if (made) return std::move(*made);
      why = std::move(made.error());
      if (why.cause() != record::Cause::read_again) break;
    }
    if (const auto name = why.find(file); name != std::string::npos) why.erase(0, name);  // without its folder
    return http_error(409, "the run's file cannot be read: " + why);
  }

 private:
  Result<const StoredRun*> known(const std::string& path) {
    const auto found = std::find_if(runs_.begin(), runs_.end(), [&](const StoredRun& run) { return run.path == path; });
    if (found != runs_.end()) {
      if (found->identity == record::identity_of(path)) return &*found;
      runs_.erase(found);
    }
    auto run = read_run(path, at_most_);
    if (!run) return tl::unexpected(std::move(run.error()));
    if (runs_.size() == kRuns) runs_.pop_front();
    return &runs_.emplace_back(std::move(*run));
  }

  const std::chrono::seconds at_most_;  // for one file
  std::deque<StoredRun> runs_;          // the newest last
};

RunDwells::RunDwells(std::chrono::seconds at_most) : reading_(std::make_shared<Reading>(at_most)) {}

bool RunDwells::is_asked(std::string_view path) {
  return path.starts_with(kRunFiles) && path.substr(kRunFiles.size()).find('/') != std::string_view::npos;
}

HttpReply RunDwells::answer(const ServiceView& now, std::string_view path, std::string_view query) const {
  path.remove_prefix(kRunFiles.size());
  const std::string file = percent_decoded(path.substr(0, path.find('/')));
  path.remove_prefix(path.find('/'));
  const bool all = path == kDwellsOfRun;
  const auto index = path.starts_with(std::string(kDwellsOfRun) + "/")
                         ? integer_of(path.substr(kDwellsOfRun.size() + 1))
                         : std::nullopt;
  if (!all && !index)
    return http_error(404, "expected /api/v1/runs/FILE/dwells or /api/v1/runs/FILE/dwells/INDEX, the index of a dwell");
  const auto page = page_of(query, kDwellsPerAnswer, {"INDEX"});
  if (!page) return http_error(400, page.error());
  if (const auto fault = query_fault(query, {}); index && fault) return http_error(400, *fault);
  if (!now.recording.state) return http_error(409, "this service does not record");
  const record::ListedRun* const listed = listed_run(now, file);
  if (listed == nullptr)
    return http_error(404, "there is no run of this name: expected a FILE that /api/v1/runs lists");
  if (const std::string why = no_dwells(now, *listed); !why.empty()) return http_error(409, why);
  HttpReply reply;
  reply.later = [reading = reading_, file, page = *page, index, in = now.recording.state->directory + "/" + file] {
    return reading->answer(in, file, [&](const StoredRun& run) -> Result<HttpReply> {
      return index ? dwell_answer(run, *index) : Result<HttpReply>(list_answer(run, file, page));
    });
  };
  return reply;
}

}  // namespace dwell
