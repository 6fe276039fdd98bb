// The events of a replay: what a service with this rig file would have told of the stream.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/ctl/replay.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/stream_events.hpp"

namespace dwell::ctl {

// Changes of state as the replay has them. Bound to one thread.
class StateEvents {
 public:
  // Call after each Replay::take(). Not needed after take_samples(): it never changes the state. `utc` stays empty.
  [[nodiscard]] std::optional<record::StoredEvent> follow(const Replay& replay);

 private:
  State state_ = State::idle;
};

// Changes of state as the replay has them; faults, losses and channels that come and go as the stream has them. What
// people did is in the parent alone. Bound to one thread.
class ChildEvents {
 public:
  // begin_ns: instant of the parent's first record. rig: the replay's. devices: the parent's device names; the stream's
  // device numbers are their indexes.
  ChildEvents(const record::RunHeader& parent, std::int64_t begin_ns, const Rig& rig, std::vector<std::string> devices);

  // Call after each record that the replay has taken; `record`: with the rig's channel numbers. Returns the events that
  // are new: changes of state at once, faults and losses of the stream once per second of stream time.
  [[nodiscard]] std::vector<record::StoredEvent> follow(const Record& record, const Replay& replay);
  // Call after the last record. Returns the faults and losses since the last follow().
  [[nodiscard]] std::vector<record::StoredEvent> finish();

 private:
  [[nodiscard]] std::string utc_of(std::int64_t t_ns) const;
  void drain(std::vector<record::StoredEvent>& into);

  std::int64_t start_utc_ns_, begin_ns_, newest_ns_, drain_ns_;
  record::StreamNames names_;
  record::StreamEvents stream_;
  StateEvents states_;
  bool run_began_ = false;
};

}  // namespace dwell::ctl
