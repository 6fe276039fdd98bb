// Deletes the runs that retention chooses, once the ledger knows.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/job_thread.hpp"
#include "daemon/record/notice.hpp"
#include "daemon/record/outcomes.hpp"
#include "daemon/record/retention.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

struct RetentionOptions {
  std::string directory;
  RetentionPolicy policy;
  std::function<bool()> clock_synchronized;  // whether the computer's clock is
};

// Bound to the recorder's thread; virtual time. The jobs' thread removes the files.
class RunDeleter {
 public:
  // Time between two looks for runs that are too old.
  static constexpr std::int64_t kPeriod_ns = 600'000'000'000;

  // Folder and jobs outlive it.
  RunDeleter(RetentionOptions options, RunFolder& folder, std::shared_ptr<RunList> list, JobThread& jobs, Tell tell);

  // Call at each turn, also while the list is not complete yet: watches for steps of the computer's clock.
  void watch_clock(const ClockPair& now);
  // One pass; the folder must be open, and the list complete. Deletes one run at a time: first the ledger is told.
  // recorded: the list's entry of the current run, as of now; null: none is recorded. due: a look is due before the
  // period is over, for a run has begun, or the list has new files.
  void turn(const ClockPair& now, const ListedRun* recorded, bool due);
  // Tells what has become of the files.
  void take_outcomes();

 private:
  void choose(const ClockPair& now, const ListedRun* recorded);
  // The listed runs as retention may see them, without the one whose deletion is under way. It deletes none that the
  // ledger does not know.
  [[nodiscard]] ListedRuns deletable(const ListedRun* recorded) const;
  // choose_deletions(), also where runs have been protected since they were listed.
  [[nodiscard]] std::vector<Deletion> chosen_of(ListedRuns& runs, const RetentionPolicy& policy,
                                                std::int64_t now_utc_ns) const;
  // Tells the ledger.
  void begin(Deletion deletion);
  // The ledger has answered.
  void erase(const Deletion& deletion, const Result<void>& told);

  const RetentionOptions options_;
  RunFolder& folder_;
  const std::shared_ptr<RunList> list_;
  JobThread& jobs_;
  const Tell tell_;
  const std::shared_ptr<Outcomes<Notice>> unlinked_ = std::make_shared<Outcomes<Notice>>();
  std::int64_t next_look_ns_ = 0;
  std::deque<Deletion> deletions_;
  struct Telling {
    Deletion deletion;
    std::future<Result<void>> told;
  };
  std::optional<Telling> telling_;  // of the deletion that is under way
  AgeDoubt age_doubt_;
  std::string doubt_;       // why no age can be believed now; empty: it can
  std::string told_doubt_;  // why old runs stay, as the log has it
};

}  // namespace dwell::record
