// Coefficients by the method of any motion beside a dwell: when they are estimated, and from which readings.
//
// A stretch begins one and a half periods before its first hold. While the dwell settles, an estimate of it is due
// - when it covers two periods of the hold;
// - each time its readings have become 1.5 times as many, up to what an estimate may take. All of these together cost
//   three times the last one.
// Where the readings contradict the chain, the search for what explains it may take minutes. So the first estimate that
// finds a contradiction puts the search off and only says so; the next one makes it, even if the dwell has settled
// meanwhile. Then the next is due when the readings have become four times as many.
// A dwell that has settled and ended gets a last estimate. Its stretch grows to a fifth of the readings that an
// estimate may take. If it has more already when the dwell has settled, there is no last estimate, since little or
// nothing of the dwell's own data would be in it. Nothing else is estimated while a dwell is measured or the
// rig is idle.
//
//   state      what is so                                 left for
//   waiting    no dwell is on                             gathering, when a dwell begins
//   gathering  the stretch grows                          complete, when its dwell has settled and the last estimate
//                                                         needs no more readings
//   complete   it takes no more readings                  gathering, when another stretch begins
//
// From any state the end of a dwell leads to waiting. Another dwell begins another stretch and drops the estimate.
// If the drive leaves a hold of eight periods within a dwell, another stretch begins; the estimate stays until there is
// a newer one. A drive that leaves one hold after another, as a ramp does, goes on with its stretch.
//
// This class decides and remembers; it does not estimate. Whoever owns it runs the jobs, on another thread or by hand.
// Virtual time; the same records and the same calls give the same jobs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/motion/hold_record.hpp"
#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/result/motion.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

// An estimate with all that it was made from, so that it can be made again. `identify --method motion` on a recording
// of just these readings gives its coefficients; where the search was put off, their uncertainties and the cause may
// differ.
struct TransientEstimate {
  MotionEstimate estimate;
  double from_s = kNaN, until_s = kNaN;  // stamps of the first and the last reading given, on the run's axis
  std::size_t given = 0;                 // readings
  // Position of the last of them in the stream of the run. They are the newest `given` samples up to there, without
  // those of auxiliary channels.
  std::uint64_t last = 0;
  bool may_search = true;                   // MotionOptions::anew
  std::vector<ChannelFault> at_fault = {};  // MotionOptions::at_fault
  // Of the last estimate of a dwell that has ended: its index, and what any motion holds against it; empty: nothing.
  std::optional<int> dwell{};
  std::string objection{};
};

// Work for whoever has time: run(), then TransientWatch::take_back(). Owns all it needs; may go to another thread.
struct TransientJob {
  std::optional<int> dwell;                   // the index of the stretch's dwell
  std::uint64_t stretch = 0;                  // its number
  std::vector<HoldRecord::Reading> readings;  // in the device's own numbers, as they came
  TransientEstimate result;                   // its estimate is not made yet
  std::stop_token stop{};                     // see MotionOptions: requested once nobody takes the result back
  std::shared_ptr<const Dwell> ended;         // the dwell as it ended; set for its last estimate only

  // Takes seconds; allocates. The rig must be the watch's. Throws Stopped soon after `stop` was requested.
  void run(const Rig& rig);
};

// Bound to one thread.
class TransientWatch {
 public:
  enum class Phase : std::uint8_t { waiting, gathering, complete };

  // Everything that is kept of the stream is allocated here: 24 bytes for each reading that an estimate takes.
  explicit TransientWatch(const Rig& rig);
  // Stops whatever job is out.
  ~TransientWatch();
  TransientWatch(TransientWatch&&) = default;
  TransientWatch& operator=(TransientWatch&&) = default;

  // A record of the stream, its instant on the run's axis, and its position. Real-time safe.
  void take(const Record& record, std::int64_t t_ns, std::uint64_t position = 0) noexcept;
  // The dwell as it stands now, and the channels whose readings are at fault (readings_at_fault.hpp). A few times a
  // second. Where a dwell ends, copies its readings: a millisecond at most.
  void follow(const Dwell& now, std::vector<ChannelFault> at_fault = {});
  // A dwell has ended; follow() may have been told already. A last estimate of the dwell before that has not begun is
  // dropped.
  void ended(const Dwell& dwell);

  // Whether a job is to be done now; at most one is out at a time.
  [[nodiscard]] bool due() const noexcept;
  // Copies the readings. Only if due(). Allocates; a millisecond at most.
  [[nodiscard]] TransientJob hand_over();
  // The estimate, to be handed on; null: its stretch is over, and it is no last estimate, so it is dropped.
  std::shared_ptr<const TransientEstimate> take_back(TransientJob job);

  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  // Of the dwell that is on; null: there is none yet. Never changed once handed out.
  [[nodiscard]] const std::shared_ptr<const TransientEstimate>& newest() const noexcept { return newest_; }

 private:
  // The readings from shortly before a hold on, of one dwell.
  struct Stretch {
    std::optional<int> dwell;                 // its index; none: no dwell is on
    std::uint64_t number = 0;                 // of stretches so far
    double start_s = kNaN;                    // when its first hold began …
    double hold_s = kNaN;                     // … and its newest
    double settled_s = kNaN;                  // of the dwell
    std::size_t handed = 0;                   // readings in the last job
    AnewSearch anew = AnewSearch::not_asked;  // of its newest estimate
  };

  [[nodiscard]] bool settled() const noexcept;
  void wait();
  void begin(const Dwell& now);
  void keep_for_last();
  [[nodiscard]] TransientJob job() const;

  std::vector<bool> counts_;  // by Rig::channels: all but auxiliary ones
  double period_s_;           // of the nominal drive
  std::size_t most_of_last_;  // readings of a last estimate
  HoldRecord record_;
  Phase phase_ = Phase::waiting;
  Stretch stretch_;
  double now_s_ = kNaN;     // of the newest reading
  std::uint64_t last_ = 0;  // position of the newest reading in record_
  bool out_ = false;        // a job is
  // Of the job that is out: stale_ once its stretch is over, of_last_ of a last job.
  std::stop_source stale_{std::nostopstate}, of_last_{std::nostopstate};
  std::vector<ChannelFault> at_fault_;
  std::shared_ptr<const TransientEstimate> newest_;
  // The last estimate of a dwell whose end is not reported yet: it may turn out only then that the dwell has settled.
  std::optional<TransientJob> unreported_;
  std::optional<TransientJob> last_job_;  // of a dwell that has ended; waits to be handed over
};

}  // namespace dwell
