// A dwell's model put to the test while the dwell is on: when verify_model() is asked, and with which readings.
//
// The readings that count are kept from ten periods before the hold begins until the dwell has settled. Then they are
// the evidence, which no longer changes: the coefficients come from later data. The model is verified when the dwell
// has settled, each time its data have become twice as long (its coefficients are better known then), and when it ends.
// Causes depend on the evidence alone, so they are looked for once.
//
// This class decides and remembers; it does not verify. Whoever owns it runs the jobs, on another thread or by hand.
// Virtual time; the same calls give the same jobs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "core/motion/hold_record.hpp"
#include "core/result/dwell.hpp"
#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/sample_history.hpp"
#include "core/verify/verification_causes.hpp"

namespace dwell {

struct VerifiedDwell {
  Dwell dwell;  // as it stood, with the coefficients that were verified
  Verification verification;
  // What it was computed from, so that it can be computed again. `dwell` stood so after the record `position` of the
  // run's stream; `ended`: it ended with that record.
  std::uint64_t position = 0;
  bool ended = false;
  // The evidence: `given` readings of the pipeline's history, from from_s to until_s on the run's axis. `last` is the
  // number of the newest one, counted from 1.
  std::uint64_t last = 0;
  std::size_t given = 0;
  double from_s = kNaN, until_s = kNaN;
};

// Work for whoever has time: run(), then VerificationWatch::take_back(). May go to another thread; shares the evidence,
// which nobody changes.
struct VerificationJob {
  std::shared_ptr<const std::vector<HoldRecord::Reading>> evidence;  // SI, on the run's axis
  VerifiedDwell result;                                              // its dwell is given
  std::shared_ptr<const Causes> causes;  // found in this evidence; null: they were not looked for

  // accuracy: as for verify_model(). Looks for causes if asks_for_causes(), but only once for the same evidence. Takes
  // seconds, with causes up to a minute. Allocates. The rig must be the watch's.
  void run(const Rig& rig, double accuracy);
};

// Bound to one thread.
class VerificationWatch {
 public:
  // Everything that is kept of the stream is allocated here: 24 bytes for each reading that a verification takes.
  explicit VerificationWatch(const Rig& rig);

  // The readings that have come since the last call. origin_ns: of the run's axis, on the history's. Real-time safe;
  // O(new readings).
  void take(const SampleHistory& history, std::int64_t origin_ns) noexcept;
  // The dwell as it stood after the record `position`. At least once a second; where it settles, copies the evidence: a
  // millisecond at most.
  void follow(const Dwell& now, std::uint64_t position = 0);
  // A dwell has ended with the record `position`.
  void ended(const Dwell& dwell, std::uint64_t position = 0);

  // So many jobs wait at most, one of a dwell, with evidence of up to 1.5 MB each. The oldest of more is dropped: that
  // dwell keeps the verdict that it has. A search for causes takes a minute or two, and a dwell that settles seldom
  // ends within half a minute. Halved, dwells in quick succession lose their last verdict; doubled, 6 MB more may be
  // held.
  static constexpr std::size_t kMostWaiting = 4;

  // Whether a job is to be done now; at most one is out at a time.
  [[nodiscard]] bool due() const noexcept { return !out_ && !waiting_.empty(); }
  // Only if due().
  [[nodiscard]] VerificationJob hand_over();
  void take_back(VerificationJob job);

  // Of the dwell that was verified last; null: none was. Never changed once handed out.
  [[nodiscard]] const std::shared_ptr<const VerifiedDwell>& newest() const noexcept { return newest_; }

 private:
  using Evidence = std::shared_ptr<const std::vector<HoldRecord::Reading>>;
  struct Hold {
    std::optional<int> dwell;  // its index; none: no dwell is on
    double start_s = kNaN;
    Evidence evidence;        // null: it has not settled
    std::uint64_t last = 0;   // number of its newest reading
    double verified_s = 0.0;  // length of the data that were verified last
  };

  void enqueue(VerificationJob job);
  [[nodiscard]] static VerificationJob job_of(const Hold& hold, const Dwell& dwell, std::uint64_t position, bool ended);

  double period_s_;  // of the nominal drive
  HoldRecord record_;
  std::uint64_t next_ = 0;  // number in the history
  std::uint64_t last_ = 0;  // number of the newest reading in record_, from 1 on
  Hold now_, before_;       // before_: the dwell before, while its end is not reported
  std::deque<VerificationJob> waiting_;
  bool out_ = false;                      // a job is
  Evidence explained_;                    // for which causes were looked for last …
  std::shared_ptr<const Causes> causes_;  // … and what was found
  std::shared_ptr<const VerifiedDwell> newest_;
};

}  // namespace dwell
