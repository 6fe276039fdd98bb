// The work beside the recording of runs: the list of runs and their audits, anchors of their heads, retention. Work
// that may take long has threads of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/record/anchor_sender.hpp"
#include "daemon/record/job_thread.hpp"
#include "daemon/record/notice.hpp"
#include "daemon/record/run_audits.hpp"
#include "daemon/record/run_deleter.hpp"
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
  // The folder outlives it.
  Housekeeper(const HousekeepingOptions& options, RunFolder& folder, std::shared_ptr<RunList> list, Tell tell);

  // One pass; the folder must be open. `recorded`: the list's entry of the run that is being recorded; null: none is.
  void turn(const ClockPair& now, const ListedRun* recorded);

  // The service ends: waits until the last anchors have arrived, so long at most.
  void settle(const ClockPair& now, std::chrono::milliseconds limit) { anchors_.settle(now, limit); }

  // Why the newest anchor did not arrive; empty: it did.
  [[nodiscard]] const std::string& anchor_trouble() const noexcept { return anchors_.trouble(); }
  // Thread-safe, short lock.
  [[nodiscard]] std::shared_ptr<const RunVerdicts> audits() const { return audits_.all(); }

 private:
  // What the thread for jobs has done for the list.
  enum class Reading : std::uint8_t { not_begun, under_way, done };
  struct Listing {
    std::atomic<Reading> directory{Reading::not_begun};
    std::atomic<bool> renewed{false};  // since somebody looked
  };

  void look_at_all(const std::string& recorded);
  // Puts the current run into the list; one that has ended stays there without an end.
  void list_current(const ListedRun* recorded);
  void list_ended(const std::vector<EndedRunFile>& ended);
  void tell_of_strangers();
  void audit(const ClockPair& now);

  const std::string directory_;
  RunFolder& folder_;
  const std::shared_ptr<RunList> list_;
  const Tell tell_;
  JobThread jobs_;
  AnchorSender anchors_;
  RunDeleter deleter_;
  RunAudits audits_;
  const std::shared_ptr<Listing> listing_ = std::make_shared<Listing>();
  bool all_listed_ = false;  // every run of the directory has been read
  bool anchor_due_ = false;  // a run has begun or ended since the last anchor
  ListedRun listed_;         // the current run, as it is in the list; no file: none goes on
};

}  // namespace dwell::record
