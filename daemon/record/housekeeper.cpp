#include "daemon/record/housekeeper.hpp"

#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

namespace dwell::record {

namespace {

// Rounded up.
std::string size_text(std::uint64_t bytes) {
  return bytes < 1'000'000 ? std::to_string((bytes + 999) / 1000) + " kB"
                           : std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

}  // namespace

// Outcomes of jobs, on their way to the recorder's thread.
struct Housekeeper::Outcomes {
  struct Outcome {
    Notice notice;           // empty text: none
    bool of_anchor = false;  // then `trouble` is how it went
    std::string trouble;
    std::uint64_t ended_heads = 0;  // HeadsToArrive::added() of the delivery
  };
  std::mutex mutex;
  std::vector<Outcome> waiting;
  bool listed = false;  // every run of the directory has been read

  void put(Outcome outcome) {
    const std::lock_guard lock(mutex);
    waiting.push_back(std::move(outcome));
  }
  bool all_listed() {
    const std::lock_guard lock(mutex);
    return listed;
  }
};

Housekeeper::Housekeeper(HousekeepingOptions options, RunFolder& folder, std::shared_ptr<RunList> list, Tell tell)
    : options_(std::move(options)),
      folder_(folder),
      list_(std::move(list)),
      tell_(std::move(tell)),
      outcomes_(std::make_shared<Outcomes>()),
      jobs_("runs"),
      audits_(options_.directory) {}

Housekeeper::~Housekeeper() = default;

void Housekeeper::turn(const ClockPair& now, const ListedRun* recorded) {
  if (!next_retention_ns_) {
    look_at_all(recorded != nullptr ? recorded->file : std::string());
    next_retention_ns_ = now.raw_ns;
  }
  // While the queue of jobs is full, ended runs and deletions wait for another turn.
  const bool room = !jobs_.full();
  // Several runs may have begun and ended since the last turn.
  const std::vector<EndedRunFile> ended = room ? folder_.take_ended() : std::vector<EndedRunFile>();
  const bool changed = room && (!ended.empty() || listed_ != (recorded != nullptr ? recorded->file : std::string()));
  if (changed) {
    list(ended, recorded);
    next_retention_ns_ = now.raw_ns;
  }
  anchor(now, ended, changed);
  retain(now);
  audit(now);
  take_outcomes();
}

void Housekeeper::look_at_all(const std::string& running) {
  jobs_.post([directory = options_.directory, running, list = list_, outcomes = outcomes_](const auto& stopping) {
    look_at_runs(
        directory, running, [&](ListedRun run) { list->put(std::move(run)); }, stopping);
    const std::lock_guard lock(outcomes->mutex);
    outcomes->listed = true;
  });
}

void Housekeeper::list(const std::vector<EndedRunFile>& ended, const ListedRun* recorded) {
  if (!ended.empty())
    jobs_.post([directory = options_.directory, ended, list = list_, closed = folder_.closed()](const auto&) {
      if (closed.valid()) closed.wait();
      for (const EndedRunFile& run : ended) list->put(look_at_run(directory, run.file));
    });
  listed_.clear();
  if (recorded == nullptr) return;
  listed_ = recorded->file;
  list_->put(*recorded);
}

void Housekeeper::anchor(const ClockPair& now, const std::vector<EndedRunFile>& ended, bool run_changed) {
  if (!run_changed && now.raw_ns < next_anchor_ns_) return;
  const double minutes = options_.anchor.minutes > 0.0 ? options_.anchor.minutes : kAnchorMinutes;
  next_anchor_ns_ = now.raw_ns + static_cast<std::int64_t>(minutes * 60e9);
  std::string lines;
  for (const EndedRunFile& run : ended) ended_heads_.add(run.head);
  std::vector<Anchor> heads(ended_heads_.all().begin(), ended_heads_.all().end());
  for (Anchor& head : folder_.heads()) heads.push_back(std::move(head));
  for (Anchor& head : heads) {
    Digest& anchored = anchored_[head.origin];
    if (std::exchange(anchored, head.head) == head.head) continue;
    head.utc = iso_utc(now.utc_ns);
    const std::string line = to_line(head);
    tell_({Notice::Grade::info, "anchor: " + line, 0, hex(head.head)});
    lines += (lines.empty() ? "" : "\n") + line;
  }
  if (anchored_.size() > kOriginsKnown) anchored_.clear();
  const bool nowhere = options_.anchor.file.empty() && options_.anchor.command.empty();
  if (nowhere) ended_heads_.arrived(ended_heads_.added());  // the log has them
  if (nowhere || lines.empty()) return;
  const bool posted =
      jobs_.post([target = options_.anchor, lines, added = ended_heads_.added(), outcomes = outcomes_](const auto&) {
        const auto done = deliver_anchor(target, lines);
        outcomes->put({{}, true, done ? std::string() : std::string(done.error()), added});
      });
  if (!posted) outcomes_->put({{}, true, "the anchors before have not arrived yet"});
}

void Housekeeper::retain(const ClockPair& now) {
  const std::string doubt = options_.retention.days ? age_doubt_.at(now, options_.clock_synchronized()) : std::string();
  if (!outcomes_->all_listed()) return;
  if (!doubt.empty()) std::erase_if(deletions_, [](const Deletion& deletion) { return deletion.by_age; });
  if (now.raw_ns >= *next_retention_ns_) {
    next_retention_ns_ = now.raw_ns + kRetentionPeriod_ns;
    choose(now, doubt);
  }
  // Deletes one run a turn, for each waits for the disk.
  if (deletions_.empty() || jobs_.full()) return;
  const Deletion deletion = std::move(deletions_.front());
  deletions_.pop_front();
  erase(deletion);
}

void Housekeeper::choose(const ClockPair& now, const std::string& doubt) {
  auto chosen = choose_deletions(deletable(), options_.retention, now.utc_ns);
  std::size_t old = 0;
  for (const Deletion& deletion : chosen) old += deletion.by_age ? 1 : 0;
  if (!doubt.empty() && old > 0) {
    RetentionPolicy by_size = options_.retention;
    by_size.days.reset();
    chosen = choose_deletions(deletable(), by_size, now.utc_ns);
  }
  deletions_.assign(chosen.begin(), chosen.end());
  if (old == 0 || std::exchange(told_doubt_, doubt) == doubt || doubt.empty()) return;
  tell_({Notice::Grade::warning,
         "runs that seem too old to be kept: " + std::to_string(old) + "; nothing is deleted by age: " + doubt,
         0,
         {}});
}

void Housekeeper::audit(const ClockPair& now) {
  if (!outcomes_->all_listed()) return;
  if (!std::exchange(told_of_strangers_, true)) tell_of_strangers();
  audits_.turn(now.raw_ns, list_->all(), folder_.key());
  for (std::string& line : audits_.take_tampered()) tell_({Notice::Grade::warning, std::move(line), 0, {}});
}

bool Housekeeper::in_ledger(const ListedRun& run) const { return folder_.file_of(run.run) == run.file; }

// The ledger was removed or an older one put back, or the files come from elsewhere. Without this word nobody would
// know before the next audit with the ledger.
void Housekeeper::tell_of_strangers() {
  const auto runs = list_->all();
  std::size_t strangers = 0;
  std::string newest;
  for (const ListedRun& run : *runs) {
    if (run.run == 0 || in_ledger(run)) continue;  // a child file has no number
    ++strangers;
    newest = run.file;
  }
  if (strangers > 0)
    tell_({Notice::Grade::warning,
           "runs that the ledger does not know: " + std::to_string(strangers) + ", the last of them " + newest +
               "; if they were recorded here, the ledger was removed or an older one put back",
           0,
           {}});
}

ListedRuns Housekeeper::deletable() const {
  ListedRuns runs = *list_->all();
  for (ListedRun& run : runs) run.kept = run.kept || !in_ledger(run);
  return runs;
}

void Housekeeper::erase(const Deletion& deletion) {
  const ListedRun& run = deletion.run;
  if (run.file == listed_ || is_kept(options_.directory, run.file)) return;
  if (auto told = folder_.run_deleted(run.run, run.head, deletion.why); !told) {
    tell_({Notice::Grade::warning,
           run.file + " is not deleted, for the ledger could not be told: " + told.error(),
           run.run,
           {}});
    return;
  }
  list_->remove(run.file);
  const std::string text = run.file + " deleted, " + size_text(run.bytes) + ": " + deletion.why;
  jobs_.post([path = options_.directory + "/" + run.file, text, number = run.run, outcomes = outcomes_](const auto&) {
    const bool gone = unlink(path.c_str()) == 0;
    for (const char* part : {"-wal", "-shm"}) unlink((path + part).c_str());
    const auto grade = gone ? Notice::Grade::info : Notice::Grade::warning;
    outcomes->put({{grade, gone ? text : path + " could not be deleted", number, {}}, false, {}});
  });
}

void Housekeeper::take_outcomes() {
  std::vector<Outcomes::Outcome> waiting;
  {
    const std::lock_guard lock(outcomes_->mutex);
    waiting.swap(outcomes_->waiting);
  }
  for (Outcomes::Outcome& outcome : waiting) {
    if (!outcome.notice.text.empty()) tell_(outcome.notice);
    if (!outcome.of_anchor) continue;
    if (!outcome.trouble.empty() && anchor_trouble_.empty())
      tell_({Notice::Grade::warning, "anchor: " + outcome.trouble, 0, {}});
    if (outcome.trouble.empty())
      ended_heads_.arrived(outcome.ended_heads);
    else
      anchored_.clear();  // all heads are sent again when the next anchor is due
    anchor_trouble_ = std::move(outcome.trouble);
  }
}

}  // namespace dwell::record
