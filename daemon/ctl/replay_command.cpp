// replay: computes a run again from its stream. With the run's own rig file, compares the results with the stored ones.
// With another rig file the results are new, and may be written to a child file.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/clock.hpp"
#include "daemon/ctl/child_events.hpp"
#include "daemon/ctl/child_file.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/event_comparison.hpp"
#include "daemon/ctl/model_check.hpp"
#include "daemon/ctl/personal_key.hpp"
#include "daemon/ctl/printout.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/replay_check.hpp"
#include "daemon/ctl/replay_printout.hpp"
#include "daemon/ctl/run_source.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/snapshot.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json.hpp"

namespace dwell::ctl {
namespace {

constexpr std::uint64_t kShowEvery = 1U << 12U;  // records

using record::Result;

// In place of an exit code: the service closed the file meanwhile, and another attempt succeeds.
constexpr int kAgain = -1;
constexpr int kTries = 5;  // a file is closed only once, and may be signed just after
constexpr std::chrono::milliseconds kPause{100};

int cannot_replay(const record::Failure& why, int code = kUsage) {
  if (why.cause() == record::Cause::read_again) return kAgain;
  tell_error(why);
  return code;
}

// Hands every record to the replay, and calls after(records) with those taken, as the replay's rig has them: one, or up
// to free() samples and ticks together. Returns the dwells that ended. If the stream breaks off, the last one ends
// there.
template <class Free, class After>
Result<std::vector<Dwell>> play(const std::string& file, record::RunReader& reader, const ChannelMap& channels,
                                Replay& replay, const Free& free, const After& after) {
  ProgressBar bar("replaying");
  std::vector<Record> mapped;
  std::vector<Dwell> dwells;
  const auto keep = [&] { dwells.insert(dwells.end(), replay.ended().begin(), replay.ended().end()); };
  std::uint64_t next_shown = kShowEvery;
  const double begin_ns = static_cast<double>(reader.begin_ns());
  const double length_ns = static_cast<double>(reader.end_ns()) - begin_ns + 1.0;
  const auto played = reader.blocks([&](std::span<const Record> records) {
    if (replay.position() == 0 && !records.empty() && !is_edge(records.front(), RunEdge::armed)) return false;
    if (!channels.same_order()) {
      mapped.assign(records.begin(), records.end());
      for (Record& record : mapped) record = channels.map(record);
      records = mapped;
    }
    while (!records.empty()) {
      const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(free(), records.size()));
      const std::size_t taken = most > 0 ? replay.take_samples(records.first(most)) : 0;
      if (taken == 0) {
        replay.take(records.front());
        if (!replay.ended().empty()) keep();
      }
      const auto newest = records.first(std::max<std::size_t>(1, taken));
      after(newest);
      if (replay.position() >= next_shown) {
        bar.show((static_cast<double>(newest.back().t_ns) - begin_ns) / length_ns);
        next_shown = replay.position() + kShowEvery;
      }
      records = records.subspan(newest.size());
    }
    return true;
  });
  if (!played) return tl::unexpected(played.error());
  if (replay.position() == 0)
    return tl::unexpected(file + ": expected a stream that begins where its pipeline was armed; there is " +
                          (reader.begin_ns() == reader.end_ns() ? "none" : "another first record"));
  replay.break_off();
  keep();
  return dwells;
}

// The device names by their numbers in the stream of this run; empty: this version cannot read its rig file.
std::vector<std::string> devices_of(const record::RunHeader& parent) {
  std::vector<std::string> names;
  if (const auto file = config::parse(parent.rig.text, parent.rig.path, {}))
    for (const Device& device : file->rig.devices) names.push_back(device.name);
  return names;
}

// A child that is compared with its parent.
struct ComparedChild {
  record::RunReader& reader;
  std::vector<std::uint64_t> without;  // positions at which the parent has a result and the child has none
  std::string note;
};

// Computes the results again with the rig file in `of`, a run or a child of it, and compares them with those that `of`
// holds. child = null: compares the run's changes of state too. Otherwise: all events of that child, and a result of
// the replay that the child lacks is a difference. Returns the exit code.
int compare(const ReplayOptions& options, record::RunReader& reader, const std::string& of,
            const record::RunHeader& header, ComparedChild* child) {
  const auto file = rig_of(header, of);
  if (!file) return cannot_replay(file.error());
  const auto channels = ChannelMap::between(reader.header(), options.file, file->rig, header.rig.path);
  if (!channels) return cannot_replay(channels.error());
  auto stored = StoredResults::open(of);
  if (!stored) return cannot_replay(stored.error());
  // As in the results that are compared.
  const RunInfo recorded{file->sha256, header.origin.version, header.start_utc};
  std::optional<ModelCheck> models;
  bool has_models = false;
  if (options.models) {
    auto opened = ModelCheck::open(reader, file->rig, file->verification.accuracy);
    if (!opened) return cannot_replay(opened.error());
    models.emplace(std::move(*opened));
  } else if (child == nullptr) {
    const auto read = reader.models([&](const record::StoredModel&) {
      has_models = true;
      return false;  // one is enough
    });
    has_models = has_models || !read;  // one that cannot be read is not compared either
  }
  Replay replay(file->rig);
  ReplayCheck check(
      std::move(*stored), [&](const Dwell& dwell) { return to_json(dwell, file->rig, recorded); },
      reader.end().has_value());
  StateEvents states;
  std::uint64_t begins_at = 0;
  ChildEvents follower(reader.header(), reader.begin_ns(), file->rig, devices_of(reader.header()));
  std::vector<record::StoredEvent> events;
  const auto add_events = [&events](std::vector<record::StoredEvent> more) {
    std::move(more.begin(), more.end(), std::back_inserter(events));
  };
  std::vector<Finding> missing;
  std::size_t gap = 0;
  const auto free = [&] {
    // The events of a child were drained at each record, so they are here as well.
    if (child != nullptr) return std::uint64_t{0};
    return std::min(check.free_until(replay), models ? models->free_until(replay) : UINT64_MAX);
  };
  const auto dwells = play(options.file, reader, *channels, replay, free, [&](std::span<const Record> taken) {
    const Record& record = taken.back();
    check.follow(replay);
    if (models) models->follow(taken, replay);
    if (child == nullptr) {
      if (is_edge(record, RunEdge::begins)) begins_at = replay.position();
      if (auto change = states.follow(replay)) events.push_back(std::move(*change));
      return;
    }
    add_events(follower.follow(record, replay));
    for (; gap < child->without.size() && child->without[gap] <= replay.position(); ++gap)
      if (replay.current())
        missing.push_back({child->without[gap], false, "none", {"result", "", "published here", kNaN, false}});
  });
  if (!dwells) return cannot_replay(dwells.error());
  auto findings = check.finish();
  if (!findings) return cannot_replay(findings.error());
  if (models) models->finish(*dwells, *findings);
  if (has_models)
    findings->notes.emplace_back("estimates by any motion and verifications are not compared; --models does that");
  for (Finding& finding : missing) findings->add(std::move(finding));
  if (child != nullptr) {
    add_events(follower.finish());
    if (auto compared = compare_events(events, child->reader, *findings); !compared)
      return cannot_replay(compared.error());
    findings->notes.push_back(child->note);
  } else if (auto compared = compare_states(std::move(events), begins_at, reader, *findings); !compared) {
    return cannot_replay(compared.error());
  }
  Printout out = printout(file->rig, {file->sha256, DWELL_VERSION, header.start_utc}, *dwells);
  const ReplayVerdict verdict = judge(*findings, header.origin, record::this_origin());
  add(verdict, *findings, header, out);
  print(out, options.json);
  return verdict.same ? kDone : kNo;
}

// Audits a file without a key. Fails, with the reason, if it was tampered with or cannot be audited.
Result<void> not_tampered(const std::string& path) {
  const auto audit = record::audit_run(path, {});
  if (!audit) return tl::unexpected(audit.error());
  if (audit->state == record::AuditState::tampered) return tl::unexpected(path + ": tampered: " + audit->where);
  return {};
}

// The positions at which the run has a result that is not final, and its child has none.
Result<std::vector<std::uint64_t>> lacking(const std::string& parent, const std::string& child) {
  auto of_parent = StoredResults::open(parent), of_child = StoredResults::open(child);
  if (!of_parent) return tl::unexpected(of_parent.error());
  if (!of_child) return tl::unexpected(of_child.error());
  const auto next = [](StoredResults& results) {
    while (results.now() != nullptr && results.now()->final) results.next();
    return results.now() != nullptr ? results.now()->position : UINT64_MAX;
  };
  std::vector<std::uint64_t> positions;
  while (of_parent->now() != nullptr) {
    const std::uint64_t wanted = next(*of_parent);
    if (wanted == UINT64_MAX) break;
    while (next(*of_child) < wanted) of_child->next();
    if (next(*of_child) != wanted) positions.push_back(wanted);
    of_parent->next();
  }
  for (const StoredResults* results : {&*of_parent, &*of_child})
    if (!results->error().empty()) return tl::unexpected(results->error());
  return positions;
}

// Compares a child file with a replay of this run that uses the child's rig file. Returns the exit code.
int check_child(const ReplayOptions& options, record::RunReader& reader) {
  auto child = record::RunReader::open(options.against);
  if (!child) return cannot_replay(child.error());
  const record::RunHeader& header = child->header();
  const auto not_of_it = [&](const std::string& why) { return cannot_replay(options.against + ": " + why, kNo); };
  if (!header.is_child()) return cannot_replay(options.against + ": is no child file; expected one");
  for (const std::string& path : {options.file, options.against})
    if (auto sound = not_tampered(path); !sound) return cannot_replay(sound.error(), kNo);
  const auto head = final_head(options.file);
  if (!head) return cannot_replay(head.error());
  if (header.parent_id != reader.header().id)
    return not_of_it("was computed from run " + header.parent_id + ", not from " + options.file + ", run " +
                     reader.header().id);
  if (header.parent_head != *head)
    return not_of_it("was computed from another state of this run: head " + header.parent_head + "; " + options.file +
                     " has " + *head);
  if (!child->end()) return not_of_it("has no end, so it is not complete");
  const auto rig = rig_of(header, options.against);
  if (!rig) return cannot_replay(rig.error());
  if (rig->sha256 != header.rig.sha256) return not_of_it("its rig file is not the one whose SHA-256 it states");
  auto without = lacking(options.file, options.against);
  if (!without) return cannot_replay(without.error());
  ComparedChild compared{*child, std::move(*without), options.against + " is of this run, head " + *head};
  return compare(options, reader, options.against, header, &compared);
}

Result<std::string> text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  if (!text) return tl::unexpected(path + " cannot be read");
  return text.str();
}

// The person's key. Says on standard error if it is new.
Result<record::SigningKey> signing_key(const std::string& given) {
  const Result<std::string> path = given.empty() ? personal_key_path() : given;
  if (!path) return tl::unexpected(path.error());
  if (!given.empty()) return record::SigningKey::load(given);
  auto key = load_or_make_key(*path);
  if (!key) return tl::unexpected(key.error());
  if (key->made) tell_error("a key of your own was made: " + *path + ", public " + key->key.public_key().vkey());
  return std::move(key->key);
}

// A child names the head of its parent, so the parent is audited first: a head that its entries do not lead to is
// nobody's.
Result<ChildFile> begin_child(const ReplayOptions& options, record::RunReader& reader, const config::RigFile& rig) {
  if (auto sound = not_tampered(options.file); !sound) return tl::unexpected(sound.error() + "; no child was written");
  auto head = final_head(options.file);
  if (!head) return tl::unexpected(head.error());
  auto text = text_of(options.rig);
  if (!text) return tl::unexpected(text.error());
  const auto key = signing_key(options.key);
  if (!key) return tl::unexpected(key.error());
  auto header = child_header(reader.header(), std::move(*head), {options.rig, rig.sha256, std::move(*text)});
  if (!header) return tl::unexpected(header.error());
  header->comment = options.comment;
  header->channels.clear();
  for (const Channel& channel : rig.rig.channels) header->channels.push_back(channel.name);
  return ChildFile::create(options.output, *header, *key, reader.begin_ns());
}

// With another rig file: a result at each position where the run published one, and a final one where a dwell ends now.
int compute_child(const ReplayOptions& options, record::RunReader& reader) {
  const auto file = config::load(options.rig, {});
  if (!file) {
    std::fputs(config::to_string(options.rig, file.error()).c_str(), stderr);
    return kUsage;
  }
  const record::RunHeader header = reader.header();
  const auto channels = ChannelMap::between(header, options.file, file->rig, options.rig);
  if (!channels) return cannot_replay(channels.error());
  auto stored = StoredResults::open(options.file);
  if (!stored) return cannot_replay(stored.error());
  std::optional<ChildFile> child;
  if (!options.output.empty()) {
    if (auto may = handon::may_make_run(options.output); !may) return cannot_replay(may.error());
    auto begun = begin_child(options, reader, *file);
    if (!begun) return cannot_replay(begun.error());
    child.emplace(std::move(*begun));
  }
  const RunInfo info{file->sha256, DWELL_VERSION, header.start_utc};
  Replay replay(file->rig);
  const auto add_result = [&](std::int64_t t_ns, bool final, const Dwell& dwell) {
    child->add(t_ns, record::StoredResult{replay.position(), final, to_json(dwell, file->rig, info)});
  };
  ChildEvents events(header, reader.begin_ns(), file->rig, devices_of(header));
  const auto each = [] { return std::uint64_t{0}; };
  const auto dwells = play(options.file, reader, *channels, replay, each, [&](std::span<const Record> taken) {
    if (!child) return;
    const Record& record = taken.back();
    for (const record::StoredEvent& event : events.follow(record, replay)) child->add(record.t_ns, event);
    for (const Dwell& dwell : replay.ended()) add_result(record.t_ns, true, dwell);
    for (; stored->now() != nullptr && stored->now()->position <= replay.position(); stored->next())
      if (!stored->now()->final)
        if (const auto current = replay.current()) add_result(record.t_ns, false, *current);
  });
  if (!dwells) return cannot_replay(dwells.error());
  if (child) {
    for (const record::StoredEvent& event : events.finish()) child->add(reader.end_ns(), event);
    if (auto finished = child->finish(reader.end_ns(), {"replay", 0, 0, record::iso_utc(utc_now_ns())}); !finished)
      return cannot_replay(finished.error());
  }
  Printout out = printout(file->rig, info, *dwells);
  add_parent(header, options.output, out);
  print(out, options.json);
  return judge(file->rig, RunSource(std::move(reader), *channels), *dwells);
}

int replay_once(const ReplayOptions& options) {
  auto reader = record::RunReader::open(options.file);
  if (!reader) return cannot_replay(reader.error());
  if (reader->header().is_child()) return cannot_replay(why_no_stream(options.file, reader->header()));
  if (!options.against.empty()) return check_child(options, *reader);
  return options.rig.empty() ? compare(options, *reader, options.file, reader->header(), nullptr)
                             : compute_child(options, *reader);
}

}  // namespace

int replay(const ReplayOptions& options) {
  for (int tries = 1; tries <= kTries; ++tries) {
    if (const int code = replay_once(options); code != kAgain) return code;
    std::this_thread::sleep_for(kPause);
  }
  tell_error(options.file + ": written to each time it was read; try again later");
  return kUsage;
}

}  // namespace dwell::ctl
