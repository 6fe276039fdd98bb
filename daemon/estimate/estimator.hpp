// The estimation: hands what the devices have delivered into the one ordered stream, the stream into the pipeline, and
// publishes what came of it.
//
// Virtual time: turn() is one pass at the instant it is given; EstimationThread calls it every 10 ms. All members are
// bound to the one thread that calls turn() and finish(), except latest(), refresh() and next_event(), which belong to
// the one reader, and rearm(), begin_run() and end_run(), which belong to one thread as well (in dwelld the event loop
// for all).
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/assembler.hpp"
#include "daemon/estimate/device_intake.hpp"
#include "daemon/estimate/publisher.hpp"
#include "daemon/estimate/run_cycle.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/log/log.hpp"
#include "daemon/traces/trace_feed.hpp"

namespace dwell {

struct EstimatorOptions {
  std::int64_t hold_back_ns = 100'000'000;  // how far the merger waits for the slowest source
  std::size_t kept_dwells = 1000;           // finished dwells kept, at most …
  // … and at most so much memory for them: a twelfth of what the unit allows the service. About 350 dwells of 30
  // elements; of a usual rig the number above is reached first.
  std::size_t kept_bytes = 80'000'000;
  gpio::Link* gpio = nullptr;  // where edges come from; must outlive the estimator; null: none
  // Where coefficients from transients and verifications are computed; null: nowhere, there are none.
  std::shared_ptr<LongWork> long_work = nullptr;
  TraceFeed* traces = nullptr;  // is given the stream, for displays; must outlive the estimator; null: nowhere
  RunOptions runs = {};
};

class Estimator {
 public:
  // devices: one per Rig::devices, in that order. The log must outlive this. wake: called when there is a new snapshot
  // or event, from the estimation thread; must not block.
  Estimator(const Rig& rig, std::vector<DeviceFeed> devices, const EstimatorOptions& options, Log& log,
            std::function<void()> wake, std::int64_t now_ns);
  Estimator(const Estimator&) = delete;
  Estimator& operator=(const Estimator&) = delete;

  // One pass at now_ns (CLOCK_MONOTONIC_RAW): everything the devices have handed in, one tick, a snapshot when one is
  // due. utc_ns: the same instant in UTC. skipped: turns left out before this one.
  void turn(std::int64_t now_ns, std::int64_t utc_ns, std::uint64_t skipped = 0);

  // The run ends: what is waiting is used, the current dwell completes, a last snapshot is published.
  void finish(std::int64_t now_ns, std::int64_t utc_ns);

  // An operator's request. It enters the stream with the next turn; false: too many at once. request: its number
  // (Record::channel). begin_run() and end_run() have no effect where runs are not bracketed. begin_run(0): the
  // recorder asks for a new run in place of the current one.
  bool rearm(std::uint16_t request = 0) noexcept {
    return ask(Kind::action, static_cast<std::uint8_t>(Action::rearm), request);
  }
  bool begin_run(std::uint16_t request) noexcept {
    return ask(Kind::run, static_cast<std::uint8_t>(RunEdge::begins), request);
  }
  bool end_run(std::uint16_t request) noexcept {
    return ask(Kind::run, static_cast<std::uint8_t>(RunEdge::ends), request);
  }
  // Whether there is room for one more request.
  [[nodiscard]] bool has_room() const noexcept { return actions_.write_available() > 0; }

  // The reader: moves on to the newest snapshot; false: there was no newer one.
  bool refresh() noexcept { return publisher_.refresh(); }
  [[nodiscard]] const Snapshot& latest() const noexcept { return publisher_.latest(); }
  // The reader: what happened next in the run; false: nothing more so far.
  bool next_event(RunEvent& out) { return publisher_.next_event(out); }

 private:
  static constexpr std::size_t kActions = 16;

  void take_edges(std::int64_t now_ns);
  void take_actions(std::int64_t now_ns);
  bool ask(Kind kind, std::uint8_t flags, std::uint16_t request) noexcept {
    return actions_.push({.channel = request, .kind = kind, .flags = flags});
  }
  // Fills ready_ from the assembler. next: Assembler::next or Assembler::flush. false: nothing came.
  bool gather(bool (Assembler::*next)(Record&) noexcept);
  // Hands the records of ready_ to the traces and the runs.
  void hand_on();
  void release();
  void settle();
  void publish(std::int64_t now_ns);

  const Rig rig_;
  gpio::Link* const gpio_;
  TraceFeed* const traces_;
  Assembler assembler_;
  std::vector<DeviceIntake> devices_;  // by Rig::devices
  Publisher publisher_;
  RunCycle cycle_;
  std::vector<Record> ready_;  // of the stream, merged and not handed on yet
  boost::lockfree::spsc_queue<Record, boost::lockfree::capacity<kActions>> actions_;  // t_ns is not filled in yet
  std::int64_t next_publish_ns_;
  std::uint64_t skipped_ = 0;
};

}  // namespace dwell
