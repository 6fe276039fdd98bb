#include "daemon/record/housekeeper.hpp"

#include <utility>

namespace dwell::record {

Housekeeper::Housekeeper(const HousekeepingOptions& options, RunFolder& folder, std::shared_ptr<RunList> list,
                         Tell tell)
    : directory_(options.directory),
      folder_(folder),
      list_(std::move(list)),
      tell_(std::move(tell)),
      jobs_("runs"),
      anchors_(options.anchor, folder, tell_),
      deleter_({options.directory, options.retention, options.clock_synchronized}, folder, list_, jobs_, tell_),
      audits_(options.directory) {}

void Housekeeper::turn(const ClockPair& now, const ListedRun* recorded) {
  const std::string file = recorded != nullptr ? recorded->file : std::string();
  if (listing_->directory.load() == Reading::not_begun) look_at_all(file);
  // While the queue of jobs is full, ended runs and deletions wait for another turn.
  const bool room = !jobs_.full();
  // Several runs may have begun and ended since the last turn.
  const std::vector<EndedRunFile> ended = room ? folder_.take_ended() : std::vector<EndedRunFile>();
  const bool changed = !ended.empty() || listed_.file != file;
  if (listed_.file != file || (recorded != nullptr && listed_.label != recorded->label)) list_current(recorded);
  if (!ended.empty()) list_ended(ended);
  // A run that has begun is anchored at once, but not before the ledger knows it.
  anchor_due_ = anchor_due_ || changed;
  const bool due = anchor_due_ && !folder_.busy();
  anchor_due_ = anchor_due_ && !due;
  anchors_.turn(now, ended, due);
  deleter_.watch_clock(now);
  if (listing_->directory.load() == Reading::done) {
    if (!folder_.busy() && !std::exchange(all_listed_, true)) tell_of_strangers();
    deleter_.turn(now, recorded, listing_->renewed.exchange(false) || changed);
    audit(now);
  }
  anchors_.take_outcomes(now);
  deleter_.take_outcomes();
}

void Housekeeper::look_at_all(const std::string& recorded) {
  listing_->directory.store(Reading::under_way);
  jobs_.post([directory = directory_, recorded, list = list_, listing = listing_](const auto& stopping) {
    look_at_runs(
        directory, recorded, [&](ListedRun run) { list->put(std::move(run)); }, stopping);
    listing->renewed.store(true);
    listing->directory.store(Reading::done);
  });
}

void Housekeeper::list_current(const ListedRun* recorded) {
  ListedRun before = std::exchange(listed_, recorded != nullptr ? *recorded : ListedRun());
  // Until it is closed; then list_ended() has it.
  before.state = "ending";
  if (!before.file.empty() && before.file != listed_.file) list_->put(std::move(before));
  if (!listed_.file.empty()) list_->put(listed_);
}

void Housekeeper::list_ended(const std::vector<EndedRunFile>& ended) {
  jobs_.post([directory = directory_, ended, list = list_, listing = listing_](const auto&) {
    for (const EndedRunFile& run : ended) list->put(look_at_run(directory, run.file));
    listing->renewed.store(true);
  });
}

// The ledger was removed or an older one put back, or the files come from elsewhere. Without this word nobody would
// know before the next audit with the ledger.
void Housekeeper::tell_of_strangers() {
  const auto runs = list_->all();
  std::size_t strangers = 0;
  std::string newest;
  for (const ListedRun& run : *runs) {
    if (run.run == 0 || folder_.knows(run.run, run.file)) continue;  // a child file has no number
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

void Housekeeper::audit(const ClockPair& now) {
  audits_.turn(now.raw_ns, list_->all(), folder_.key());
  for (std::string& line : audits_.take_tampered()) tell_({Notice::Grade::warning, std::move(line), 0, {}});
}

}  // namespace dwell::record
