// The work beside the recording of runs: the list of runs and their audits, anchors of their heads, retention. Work
// that may take long has threads of its own.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/anchor_delivery.hpp"
#include "daemon/record/digest.hpp"
#include "daemon/record/heads_to_arrive.hpp"
#include "daemon/record/job_thread.hpp"
#include "daemon/record/notice.hpp"
#include "daemon/record/retention.hpp"
#include "daemon/record/run_audits.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

struct HousekeepingOptions {
  std::string directory;
  RetentionPolicy retention;
  AnchorTarget anchor;
  // Whether the computer's clock is synchronized; tests give their own.
  std::function<bool()> clock_synchronized = record::clock_synchronized;
};

// Bound to the recorder's thread; virtual time.
class Housekeeper {
 public:
  // Time between two anchors in the journal if the rig file states none.
  static constexpr double kAnchorMinutes = 10.0;
  // Time between two looks of retention for runs that are too old. It also looks when a run begins or ends.
  static constexpr std::int64_t kRetentionPeriod_ns = 600'000'000'000;

  // The folder and `list` outlive it.
  Housekeeper(HousekeepingOptions options, RunFolder& folder, std::shared_ptr<RunList> list, Tell tell);
  ~Housekeeper();

  // One pass; the folder must be open. `recorded`: the list's entry of the run that is being recorded; null: none is.
  void turn(const ClockPair& now, const ListedRun* recorded);

  // Why the newest anchor did not arrive; empty: it did.
  [[nodiscard]] const std::string& anchor_trouble() const noexcept { return anchor_trouble_; }
  // Thread-safe, short lock.
  [[nodiscard]] std::shared_ptr<const RunVerdicts> audits() const { return audits_.all(); }

 private:
  static constexpr std::size_t kOriginsKnown = 1000;  // a forgotten head is anchored again
  struct Outcomes;

  void look_at_all(const std::string& running);
  void list(const std::vector<EndedRunFile>& ended, const ListedRun* recorded);
  void anchor(const ClockPair& now, const std::vector<EndedRunFile>& ended, bool run_changed);
  void retain(const ClockPair& now);
  void choose(const ClockPair& now, const std::string& doubt);
  void audit(const ClockPair& now);
  [[nodiscard]] bool in_ledger(const ListedRun& run) const;
  void tell_of_strangers();
  // The listed runs as retention may see them: it deletes none that the ledger does not know.
  [[nodiscard]] ListedRuns deletable() const;
  void erase(const Deletion& deletion);
  void take_outcomes();

  const HousekeepingOptions options_;
  RunFolder& folder_;
  const std::shared_ptr<RunList> list_;
  const Tell tell_;
  const std::shared_ptr<Outcomes> outcomes_;
  JobThread jobs_;
  RunAudits audits_;
  std::string listed_;              // file of the current run
  bool told_of_strangers_ = false;  // or there were none
  std::int64_t next_anchor_ns_ = 0;
  std::optional<std::int64_t> next_retention_ns_;  // none until the first turn, which reads the directory
  std::map<std::string, Digest> anchored_;         // newest head by origin
  HeadsToArrive ended_heads_;
  std::deque<Deletion> deletions_;
  AgeDoubt age_doubt_;
  std::string told_doubt_;  // why old runs stay, as the log has it
  std::string anchor_trouble_;
};

}  // namespace dwell::record
