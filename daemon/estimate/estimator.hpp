// The estimation: drains the devices' rings, merges, feeds the pipeline, publishes snapshots.
//
// Virtual time: turn() is one pass at the instant it is given; EstimationThread calls it every 10 ms. All members are
// bound to the one thread that calls turn() and finish(), except latest() and refresh(), which belong to the one
// reader, and rearm(), which belongs to one thread as well (in dwelld the event loop for all three).
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/assembler.hpp"
#include "daemon/acquire/device_link.hpp"
#include "daemon/estimate/channel_watch.hpp"
#include "daemon/estimate/device_lines.hpp"
#include "daemon/estimate/kept_dwells.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/estimate/triple_buffer.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/log/log.hpp"

namespace dwell {

struct EstimatorOptions {
  std::int64_t hold_back_ns = 100'000'000;  // how far the merger waits for the slowest source
  std::size_t kept_dwells = 1000;           // finished dwells kept, at most …
  // … and at most so much memory for them: a twelfth of what the unit allows the service. About 350 dwells of 30
  // elements; of a usual rig the number above is reached first.
  std::size_t kept_bytes = 80'000'000;
  std::vector<double> nominal_rate_hz;  // per channel, 0: not known
  std::vector<bool> leads;              // per device: stamps may run ahead of the clock; missing: they may not
  gpio::Link* gpio = nullptr;           // where edges come from; must outlive the estimator; null: none
};

class Estimator {
 public:
  // links: one per Rig::devices, in that order, or null; they and the log must outlive this. published: called after
  // each snapshot, from the estimation thread; must not block.
  Estimator(const Rig& rig, std::vector<DeviceLink*> links, const EstimatorOptions& options, Log& log,
            std::function<void()> published, std::int64_t now_ns);
  ~Estimator();

  // One pass at now_ns (CLOCK_MONOTONIC_RAW): everything the devices have handed in, one tick, a snapshot when one is
  // due. utc_ns: the same instant in UTC. skipped: turns left out before this one.
  void turn(std::int64_t now_ns, std::int64_t utc_ns, std::uint64_t skipped = 0);

  // The run ends: what is waiting is used, the current dwell completes, a last snapshot is published.
  void finish(std::int64_t now_ns, std::int64_t utc_ns);

  // The operator's rearm, entering the stream with the next turn; false: too many at once.
  bool rearm() noexcept { return actions_.push(Action::rearm); }

  // The reader: moves on to the newest snapshot; false: there was no newer one.
  bool refresh() noexcept { return snapshots_.update(); }
  [[nodiscard]] const Snapshot& latest() const noexcept { return snapshots_.front(); }

 private:
  void take_events(std::size_t device, std::int64_t now_ns);
  void take_samples(std::size_t device, std::int64_t now_ns);
  void enters(Record& record);
  void admitted(std::size_t device, const Record& record, Merger::Admission admission, std::int64_t now_ns);
  void heard(std::size_t device, const Record& record, std::int64_t now_ns);
  [[nodiscard]] bool stamped_ahead(std::size_t device, const Record& record, std::int64_t now_ns);
  void note_untimely(std::size_t channel, std::int64_t t_ns, std::int64_t now_ns);
  void find_untimely(std::int64_t now_ns);
  void find_hung(std::int64_t now_ns);
  void offer_states();
  void admit_state(std::size_t device, std::size_t channel, std::int64_t t_ns, Fault fault);
  void find_silence(std::int64_t now_ns);
  void take_edges(std::int64_t now_ns);
  void release(bool everything);
  void feed(const Record& record);
  void note(std::uint8_t change);
  void settle_counters();
  void publish(std::int64_t now_ns);
  // What of the channels' changes and the faults so far the log is told of.
  void tell_recoveries(std::size_t device, std::int64_t now_ns);
  void tell_counted_faults(std::int64_t now_ns);
  void tell_stale(std::size_t device, std::int64_t now_ns);
  [[nodiscard]] std::uint64_t occurrences(std::size_t device, Fault fault) const;

  struct PerChannel {
    std::uint64_t handed = 0;  // samples given to the pipeline
    std::uint8_t gap = 0;      // samples were lost on the way to the merger
    double half_width_s = 0.0;
    bool recovered = false;     // within this turn
    bool stale = false;         // likewise
    std::int64_t stale_ns = 0;  // for how long it had been stale
    bool ever_heard = false;
    std::int64_t untimely_since_ns = 0;  // since when none of its samples could be put in order; 0: they can
    std::int64_t untimely_by_ns = 0;     // by which the newest was too old; negative: stamped ahead of the clock
    std::optional<Record> state;         // its newest change of state, for which the merger had no room
  };
  struct PerDevice {
    std::optional<DeviceLines> lines;  // none: no link
    std::uint64_t silences = 0;        // times that channels fell silent
    std::uint64_t untimely = 0;        // times that nothing of a channel could be put in order
    bool hangs = false;                // its driver has not turned for too long
  };

  const Rig rig_;
  const std::vector<DeviceLink*> links_;
  const EstimatorOptions options_;
  Log& log_;
  const std::function<void()> published_;
  Assembler assembler_;
  Pipeline pipeline_;
  ChannelWatch watch_;
  boost::lockfree::spsc_queue<Action> actions_;
  std::vector<Record> scratch_;
  std::vector<PerChannel> channels_;
  std::vector<PerDevice> devices_;
  std::int64_t next_publish_ns_ = 0;
  std::int64_t start_utc_ns_ = 0;
  State state_ = State::idle;
  KeptDwells finished_;
  std::uint64_t sequence_ = 0;
  std::uint64_t skipped_ = 0;
  TripleBuffer<Snapshot> snapshots_;
};

}  // namespace dwell
