// The verifications that a run published, each with its dwell and its evidence, as a replay comes to them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/verify/verification_watch.hpp"
#include "daemon/ctl/newest_readings.hpp"
#include "daemon/ctl/replay.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

struct PublishedVerification {
  record::StoredModel stored;
  VerifiedDwell of;  // what it was computed from; of the dwell the index alone; the verification is empty
};

// Bound to one thread. Memory: 24 bytes for each reading of the largest evidence and of those that are kept.
class VerificationsAgain {
 public:
  // A file whose entry names more is not Dwell's: a verification takes 64 000.
  static constexpr std::size_t kMostReadings = 100'000;
  // Verifications whose evidence waits for their dwell, at most; that of any further one is not kept, and it has no
  // job. The service has 5 at once (VerificationWatch::kMostWaiting and one). Doubled: 75 MB more for a hostile file.
  static constexpr std::size_t kMostKept = 32;

  // published: each with at most kMostReadings.
  explicit VerificationsAgain(std::vector<PublishedVerification> published);

  // How many records the replay may take before take() must be called.
  [[nodiscard]] std::uint64_t free_until(const Replay& replay) const noexcept;
  // Called when its dwell and its evidence are there: the job to be run.
  using Make = std::function<void(record::StoredModel, VerificationJob)>;
  // Call after each record that the replay has taken. It may be skipped for the next free_until() samples and ticks,
  // but not for more than a second of the stream: readings would be lost. origin_ns: t = 0 of the run.
  void take(const Replay& replay, std::int64_t origin_ns, const Make& make);
  // Call after the last take(): those without a job. The replay lacks their dwell or their readings.
  [[nodiscard]] std::vector<PublishedVerification> left() const;

 private:
  using Evidence = std::shared_ptr<const std::vector<HoldRecord::Reading>>;
  struct Awaited {
    PublishedVerification published;
    Evidence evidence;  // null: it has not come by
  };

  void gather(const SampleHistory& history, std::int64_t origin_ns);
  void keep_evidence();

  std::vector<Awaited> by_position_;          // of its dwell
  std::vector<std::size_t> by_last_;          // indexes into by_position_, by the number of the newest reading
  std::size_t next_ = 0, next_evidence_ = 0;  // of these two
  NewestReadings newest_;
  std::uint64_t gathered_ = 0;  // readings of the replay's history
  std::size_t kept_ = 0;        // of by_position_ with evidence
  std::vector<PublishedVerification> left_;
};

}  // namespace dwell::ctl
