// Sends the heads of runs and ledger to the place where they are anchored, and again until they have arrived there.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "daemon/record/anchor_delivery.hpp"
#include "daemon/record/digest.hpp"
#include "daemon/record/heads_to_arrive.hpp"
#include "daemon/record/job_thread.hpp"
#include "daemon/record/notice.hpp"
#include "daemon/record/outcomes.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

// Bound to the recorder's thread; virtual time. A thread of its own delivers: the place may hang.
class AnchorSender {
 public:
  // A delivery that takes longer is a trouble. A command is given up after kAnchorCommandLimit, a file is not.
  static constexpr std::int64_t kLate_ns = 60'000'000'000;

  // The folder outlives it.
  AnchorSender(AnchorTarget target, RunFolder& folder, Tell tell);

  // One pass; the folder must be open. ended: the runs that have ended since the last pass. run_changed: a run has
  // begun or ended, so that anchors are due.
  void turn(const ClockPair& now, const std::vector<EndedRunFile>& ended, bool run_changed);
  // Takes in how deliveries went, and tells of the first that failed.
  void take_outcomes(const ClockPair& now);
  // Waits until all has been delivered, so long at most. false: it has not.
  bool wait(std::chrono::milliseconds limit) const { return jobs_.settle(limit); }
  // The same as the service ends; tells what has not arrived.
  void settle(const ClockPair& now, std::chrono::milliseconds limit);

  // Why the newest delivery did not arrive; empty: it did.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }

 private:
  static constexpr std::size_t kOriginsKnown = 1000;  // a forgotten head is told and sent again
  struct Delivered {
    std::string trouble;            // empty: it arrived
    std::uint64_t ended_heads = 0;  // HeadsToArrive::added() of it
  };

  void deliver(const ClockPair& now, std::string lines);
  void trouble_is(std::string trouble);

  const AnchorTarget target_;
  RunFolder& folder_;
  const Tell tell_;
  const std::shared_ptr<Outcomes<Delivered>> delivered_ = std::make_shared<Outcomes<Delivered>>();
  JobThread jobs_{"anchors"};
  std::int64_t next_ns_ = 0;
  std::deque<std::int64_t> under_way_;  // deliveries: since when the first goes on; when the others were posted
  // Newest head by origin: in the log; under way or arrived, of the ledger and the newest run.
  std::map<std::string, Digest> told_, sent_;
  HeadsToArrive ended_heads_;
  std::string trouble_;
};

}  // namespace dwell::record
