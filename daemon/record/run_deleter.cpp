#include "daemon/record/run_deleter.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <set>
#include <string_view>
#include <utility>

namespace dwell::record {
namespace {

// Rounded up, to a tenth of a megabyte from one on.
std::string size_text(std::uint64_t bytes) {
  if (bytes < 1'000'000) return std::to_string((bytes + 999) / 1000) + " kB";
  const std::uint64_t tenths = (bytes + 99'999) / 100'000;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " MB";
}

}  // namespace

RunDeleter::RunDeleter(RetentionOptions options, RunFolder& folder, std::shared_ptr<RunList> list, JobThread& jobs,
                       Tell tell)
    : options_(std::move(options)), folder_(folder), list_(std::move(list)), jobs_(jobs), tell_(std::move(tell)) {}

void RunDeleter::watch_clock(const ClockPair& now) {
  if (options_.policy.days) doubt_ = age_doubt_.at(now, options_.clock_synchronized());
}

void RunDeleter::turn(const ClockPair& now, const ListedRun* recorded, bool due) {
  if (!doubt_.empty()) std::erase_if(deletions_, [](const Deletion& deletion) { return deletion.by_age; });
  const auto answered = [this] {
    return telling_->told.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  if (telling_ && !jobs_.full() && answered()) {
    Telling told = *std::exchange(telling_, std::nullopt);
    erase(told.deletion, told.told.get());
  }
  if (due || now.raw_ns >= next_look_ns_) {
    next_look_ns_ = now.raw_ns + kPeriod_ns;
    choose(now, recorded);
  }
  if (telling_ || deletions_.empty() || jobs_.full()) return;
  Deletion deletion = std::move(deletions_.front());
  deletions_.pop_front();
  if (recorded == nullptr || deletion.run.file != recorded->file) begin(std::move(deletion));
}

void RunDeleter::choose(const ClockPair& now, const ListedRun* recorded) {
  ListedRuns runs = deletable(recorded);
  auto chosen = chosen_of(runs, options_.policy, now.utc_ns);
  const auto old = std::count_if(chosen.begin(), chosen.end(), [](const Deletion& one) { return one.by_age; });
  if (!doubt_.empty() && old > 0) {
    RetentionPolicy by_size = options_.policy;
    by_size.days.reset();
    chosen = chosen_of(runs, by_size, now.utc_ns);
  }
  deletions_.assign(chosen.begin(), chosen.end());
  if (old == 0 || std::exchange(told_doubt_, doubt_) == doubt_ || doubt_.empty()) return;
  tell_({Notice::Grade::warning,
         "runs that seem too old to be kept: " + std::to_string(old) + "; nothing is deleted by age: " + doubt_,
         0,
         {}});
}

ListedRuns RunDeleter::deletable(const ListedRun* recorded) const {
  ListedRuns runs = *list_->all();
  if (telling_) std::erase_if(runs, [this](const ListedRun& run) { return run.file == telling_->deletion.run.file; });
  for (ListedRun& run : runs) {
    run.kept = run.kept || !folder_.knows(run.run, run.file);
    if (recorded != nullptr && run.file == recorded->file) run.bytes = recorded->bytes;
  }
  return runs;
}

std::vector<Deletion> RunDeleter::chosen_of(ListedRuns& runs, const RetentionPolicy& policy,
                                            std::int64_t now_utc_ns) const {
  for (;;) {
    std::vector<Deletion> chosen = choose_deletions(runs, policy, now_utc_ns);
    std::set<std::string_view> kept;
    for (const Deletion& deletion : chosen)
      if (is_kept(options_.directory, deletion.run.file)) kept.insert(deletion.run.file);
    if (kept.empty()) return chosen;
    for (ListedRun& run : runs) run.kept = run.kept || kept.contains(run.file);
  }
}

void RunDeleter::begin(Deletion deletion) {
  if (is_kept(options_.directory, deletion.run.file)) return;
  auto told = folder_.run_deleted(deletion.run.run, deletion.why);
  telling_.emplace(Telling{std::move(deletion), std::move(told)});
}

void RunDeleter::erase(const Deletion& deletion, const Result<void>& told) {
  const ListedRun& run = deletion.run;
  if (!told) {
    tell_({Notice::Grade::warning,
           run.file + " is not deleted, for the ledger could not be told: " + told.error(),
           run.run,
           {}});
    deletions_.clear();  // the others would fail alike
    return;
  }
  list_->remove(run.file);
  const std::string text = run.file + " deleted, " + size_text(run.bytes) + ": " + deletion.why;
  jobs_.post([path = options_.directory + "/" + run.file, file = run.file, text, number = run.run, list = list_,
              unlinked = unlinked_](const auto&) {
    const bool gone = unlink(path.c_str()) == 0 || errno == ENOENT;
    for (const char* part : {"-wal", "-shm"}) unlink((path + part).c_str());
    list->remove(file);  // a job before this one may have listed it anew
    const auto grade = gone ? Notice::Grade::info : Notice::Grade::warning;
    unlinked->put({grade, gone ? text : path + " could not be deleted", number, {}});
  });
}

void RunDeleter::take_outcomes() {
  for (const Notice& notice : unlinked_->take()) tell_(notice);
}

}  // namespace dwell::record
