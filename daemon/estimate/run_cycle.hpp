// Decides when runs begin and end, which pipeline takes the stream, and what is shown meanwhile.
//
// Without bracketing there is one run, as long as the session. With bracketing, runs begin and end with the drive or at
// an operator's request:
//
//   waiting   no run goes on. Two pipelines live, born one span apart (record/stream_sink.hpp). As soon as the elder
//             sees the drive, a run begins; it reaches back to that pipeline's birth
//   running   one pipeline. A run of the drive ends when the drive has been idle for a span. A run of an operator ends
//             with `stop` alone
//   held      waiting, after an operator has stopped a run while the drive was on. No run begins before the drive has
//             been idle for a span: else the stop would be undone within a second
//
// `start` ends the current run, if any, and begins one with a new pipeline. The recorder may ask for the same; the new
// run then counts as begun by whoever began the old one. Requests come as records of Kind::run, at their place in the
// stream. The recorder does not get these, but the Kind::run records made here.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/estimate/known_states.hpp"
#include "daemon/estimate/long_work.hpp"
#include "daemon/estimate/nursery.hpp"
#include "daemon/estimate/run_pipeline.hpp"
#include "daemon/estimate/run_tap.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/estimate/stream_accounts.hpp"

namespace dwell {

struct RunOptions {
  bool bracketed = false;              // whether runs begin and end within the session
  record::StreamSink* sink = nullptr;  // gets the stream and the results; may be null; must outlive the estimation
  double every_s = 1.0;                // stream time between two results of a current dwell
  bool births_aside = false;           // a thread makes the pipelines; false: virtual time
};

// Bound to the estimation thread; may be constructed on another. Real-time safe except when a dwell, a state or a run
// ends, or an operator starts a run. At an operator's start or stop, and at the recorder's restart, it may have to wait
// until a pipeline is made.
class RunCycle {
 public:
  using Tell = std::function<void(RunEvent)>;

  // The span: a run begins at least so long before the drive does, and ends after the drive has been idle for so long.
  // 10 s, or 8 periods of the slowest drive searched for if that is longer: a drive is recognized within 4 (two windows
  // of two periods). Halved, a slow drive may begin between two pipelines, and a pause between two dwells ends the run.
  [[nodiscard]] static std::int64_t span_ns(const Rig& rig) noexcept;
  // A drive that cannot be seen (State::fault: its transducer or its pulses are missing) ends its run only after so
  // many spans, at least a minute: time to plug a cable in again. Doubled, a rig that is switched off is recorded for
  // longer.
  static constexpr std::int64_t kUnseenSpans = 6;

  // The rig must be valid. kept: bounds the finished dwells in memory. tell: receives the events of the shown run.
  RunCycle(const Rig& rig, const RunOptions& options, const KeptDwells& kept, const std::shared_ptr<LongWork>& work,
           Tell tell);

  // The two clocks at one instant, before the records of a turn.
  void set_clocks(std::int64_t now_ns, std::int64_t utc_ns) noexcept;
  // The next record of the stream, as merged.
  void take(const Record& record);
  // Takes samples and ticks from the front of `records`, as take() would one by one. Stops where a dwell may end or
  // the state change, and after the record at which a result is due. Returns how many it took; 0: take() must take the
  // next one, as always while no dwell of a run is on. Costs less than take().
  [[nodiscard]] std::size_t take_samples(std::span<const Record> records);
  // The end of the session, at t_ns: the run ends, the current dwell completes.
  void finish(std::int64_t t_ns);

  // Fills in the run and its dwells, and gives the model's work its turn. Call at least once a second.
  void show(Snapshot& to);
  // Fills in the live values of the channels.
  [[nodiscard]] const Pipeline& pipeline() const noexcept { return live_.front()->measurement().pipeline(); }
  [[nodiscard]] const StreamAccounts& accounts() const noexcept { return accounts_; }

 private:
  // What the view shows of the last run until the next one begins.
  struct Past {
    std::shared_ptr<const FinishedDwells> finished;  // null: there is no run before
    std::uint64_t forgotten = 0;
    Dwell last;  // the last dwell as it ended; if none ended, the dwell as it stood. Its reason is the stop
    std::int64_t start_utc_ns = 0, origin_ns = 0;
    std::unique_ptr<ModelWork> model;  // the last dwell's verification may not be done yet
  };

  void give(const Record& record);
  void follow_course();
  void obey(const Record& request);
  void begin(std::uint16_t request);
  void end(EndOfRun why, std::uint16_t request);
  void renew();
  void add(std::unique_ptr<RunPipeline> newborn);
  void announce_birth();
  // Replaces all live pipelines by this one. A run must have ended before.
  void replace(std::unique_ptr<RunPipeline> newborn);
  [[nodiscard]] static Past left_by(RunPipeline& run);
  void drop(std::size_t pipeline);
  // Keeps the newest dwell with coefficients of the run that has ended.
  void remember_earlier();
  // Whether the drive is on. A newborn pipeline does not know it yet: then what the one before it knew holds.
  [[nodiscard]] bool drive_on() const;
  void told(RunPipeline& by, RunEvent event);
  void tell_state();
  [[nodiscard]] bool nothing_waits() const noexcept;

  const bool bracketed_;
  const std::int64_t span_ns_;
  const Tell tell_;
  RunTap tap_;
  Nursery nursery_;
  std::vector<std::unique_ptr<RunPipeline>> live_;  // the elder first, which is the one shown; never empty
  StreamAccounts accounts_;
  KnownStates states_;
  RunView run_;
  // What drive_on() said when the shown pipeline replaced another one: a newborn recognizes no drive within its first
  // periods.
  bool drive_was_on_ = false;
  Past past_;
  EarlierDwell earlier_;
  State told_ = State::idle;
  std::int64_t newest_ns_ = 0;  // of the stream
  std::int64_t first_utc_ns_ = 0, utc_less_now_ns_ = 0;
};

}  // namespace dwell
