// What goes on beside the recording of runs: the list of them, anchors of their heads, retention. Whatever may take
// long is done on a thread of its own.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>

#include "daemon/record/anchor_delivery.hpp"
#include "daemon/record/digest.hpp"
#include "daemon/record/job_thread.hpp"
#include "daemon/record/notice.hpp"
#include "daemon/record/retention.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

struct HousekeepingOptions {
  std::string directory;
  RetentionPolicy retention;
  AnchorTarget anchor;
};

// Bound to the recorder's thread; virtual time.
class Housekeeper {
 public:
  // Between two anchors in the journal where the rig file names no time.
  static constexpr double kAnchorMinutes = 10.0;
  // Retention looks for runs that have grown too old so often, and whenever a run has ended.
  static constexpr std::int64_t kRetentionPeriod_ns = 600'000'000'000;

  // The folder and `list` outlive it.
  Housekeeper(HousekeepingOptions options, RunFolder& folder, std::shared_ptr<RunList> list, Tell tell);
  ~Housekeeper();

  // One pass: the folder is open. `recorded`: the run that is recorded, as it is to be listed; null: none is.
  void turn(const ClockPair& now, const ListedRun* recorded);

  // Why the newest anchor did not arrive; empty: it did.
  [[nodiscard]] const std::string& anchor_trouble() const noexcept { return anchor_trouble_; }

 private:
  static constexpr std::size_t kOriginsKnown = 1000;  // a head that is forgotten is anchored once more
  struct Outcomes;

  void look_at_all(const std::string& running);
  void list(const ListedRun* recorded);
  void anchor(const ClockPair& now, bool run_changed);
  void retain(const ClockPair& now);
  void erase(const Deletion& deletion);
  void take_outcomes();

  const HousekeepingOptions options_;
  RunFolder& folder_;
  const std::shared_ptr<RunList> list_;
  const Tell tell_;
  const std::shared_ptr<Outcomes> outcomes_;
  JobThread jobs_;
  std::string listed_;  // file of the run that goes on
  std::int64_t next_anchor_ns_ = 0, next_retention_ns_ = 0;
  std::map<std::string, Digest> anchored_;  // newest head by origin
  std::deque<Deletion> deletions_;
  std::string anchor_trouble_;
};

}  // namespace dwell::record
