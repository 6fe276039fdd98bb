// The verifications that a run published, each with its dwell and its evidence, as a replay comes to them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/motion/hold_record.hpp"
#include "core/verify/verification_watch.hpp"
#include "daemon/ctl/replay.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

struct PublishedVerification {
  record::StoredModel stored;
  VerifiedDwell of;  // what it was computed from; dwell and verification are empty
};

// Bound to one thread. Memory: 24 bytes for each reading of the largest evidence and of those that are kept.
class VerificationsAgain {
 public:
  // A verification with more readings than this is none of Dwell's.
  static constexpr std::size_t kMostReadings = 100'000;

  // So much evidence is kept at once. The service holds that of five dwells at most (VerificationWatch::kMostWaiting).
  static constexpr std::size_t kMostKept = 16;

  // published: each with at most kMostReadings.
  explicit VerificationsAgain(std::vector<PublishedVerification> published);

  // How many records the replay may take before take() must be called.
  [[nodiscard]] std::uint64_t free_until(const Replay& replay) const noexcept;
  // Called when its dwell and its evidence are there: the job to be run.
  using Make = std::function<void(const PublishedVerification&, VerificationJob)>;
  // Call after each record that the replay has taken, except for so many samples and ticks as free_until() says; at
  // least once for each second of the stream. origin_ns: t = 0 of the run.
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
  [[nodiscard]] bool may_keep();

  std::vector<Awaited> by_position_;         // of its dwell
  std::vector<std::size_t> by_last_;         // indexes into by_position_, by the number of the newest reading
  std::size_t next_ = 0, next_evidence_ = 0;  // of these two
  HoldRecord newest_;
  std::uint64_t gathered_ = 0;  // readings of the replay's history
  std::vector<std::weak_ptr<const std::vector<HoldRecord::Reading>>> kept_;
  std::vector<PublishedVerification> left_;
};

}  // namespace dwell::ctl
