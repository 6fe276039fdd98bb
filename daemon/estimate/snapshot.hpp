// What the estimation thread publishes: snapshots (the dwell as it stands, every channel, every device), of which the
// newest counts, and events, none of which may be missed. Plain data, never changed once published. The channels are
// those of Rig::channels, the devices those of Rig::devices, in that order.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/motion/transient_watch.hpp"
#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "core/verify/verification_watch.hpp"
#include "daemon/acquire/channel_counters.hpp"

namespace dwell {

// What the arrivals of a channel's samples say of the clock behind them, against the host's.
struct ClockView {
  Clock kind = Clock::host;
  // NaN while no constant rate is recognized; otherwise, with Clock::device, the samples carry recovered instants.
  double rate_hz = kNaN;    // of that clock, samples lost on the way included
  double jitter_s = kNaN;   // standard deviation of the stamps from it
  double drift_ppm = kNaN;  // of the rate from the device's `rate`; NaN: none is stated
  std::uint64_t lost = 0;   // samples recognized as lost before they arrived
};

struct ChannelView {
  double value = kNaN;          // the newest reading in the channel's own unit
  std::int64_t heard_ns = -1;   // CLOCK_MONOTONIC_RAW, when it was taken in; -1: never
  Fault fault = Fault::silent;  // none: it delivers
  std::string reason;           // in words, why it does not
  bool overrange = false;
  Condition condition = Condition::unheard;  // of its readings …
  std::string condition_reason;              // … in words, with figures; empty: nothing is wrong with them
  double rate_hz = 0.0;                      // samples per second, over the last second or so
  ClockView clock;
  double half_width_s = 0.0;  // the newest sample's true instant is its stamp ± this
  std::uint64_t gaps = 0;     // times that samples were lost
  Tally tally;
};

struct DeviceView {
  std::string name;
  std::string driver;
  bool up = false;        // at least one of its channels delivers
  bool recorded = false;  // it plays a recording, as its driver says
  bool ended = false;     // a recording played to its end: its thread has nothing left to turn for
  std::array<std::uint64_t, kFaultCount> faults{};  // occurrences by kind
  std::uint64_t foreign = 0;                        // readings of channels that are not the device's
};

// The state of the run.
struct RunView {
  bool bracketed = false;    // runs begin and end within the session, and are recorded
  bool on = false;           // a run goes on
  bool by_operator = false;  // an operator began it
  bool held = false;         // an operator stopped a run: none begins by itself before the drive has rested
  std::uint32_t number = 0;  // runs of the session so far
};

// The newest verdict on the model of each dwell of a run that was verified or objected to, in the order of the dwells.
struct VerifiedModel {
  int dwell = 0;  // its index
  ModelVerdict model;
};
using VerifiedModels = std::vector<VerifiedModel>;
// Of that dwell; null: none is known. models: may be null. O(log dwells), no allocation.
[[nodiscard]] inline const VerifiedModel* verdict_on(const VerifiedModels* models, int dwell) noexcept {
  if (models == nullptr) return nullptr;
  const auto at = std::lower_bound(models->begin(), models->end(), dwell,
                                   [](const VerifiedModel& m, int index) { return m.dwell < index; });
  return at != models->end() && at->dwell == dwell ? &*at : nullptr;
}

using FinishedDwells = std::vector<std::shared_ptr<const Dwell>>;

// The newest dwell with coefficients of an earlier run of the session.
struct EarlierDwell {
  std::shared_ptr<const Dwell> dwell;  // null: there is none
  std::int64_t start_utc_ns = 0;       // t = 0 of its run
};

struct Snapshot {
  std::uint64_t sequence = 0;     // 0: nothing published yet
  std::int64_t t_ns = 0;          // CLOCK_MONOTONIC_RAW
  std::int64_t start_utc_ns = 0;  // t = 0 of the dwells; 0: not yet
  std::int64_t origin_ns = 0;     // the same instant on the stream's clock, exactly
  RunView run;
  Dwell dwell;
  // Coefficients of `dwell` by the method of any motion; null: none yet. Made by the worker, handed on unchanged:
  // whoever holds the pointer may read it on any thread.
  std::shared_ptr<const TransientEstimate> transient;
  std::optional<Agreement> transient_agreement;   // of these with the coefficients of `dwell`; nullopt: not compared
  std::shared_ptr<const VerifiedDwell> verified;  // the newest verification of the run; null: none yet. As `transient`
  std::shared_ptr<const VerifiedModels> models;   // of the run's dwells; null: none was verified yet
  std::vector<ChannelView> channels;
  std::vector<DeviceView> devices;
  std::shared_ptr<const FinishedDwells> finished;  // oldest first
  std::uint64_t forgotten = 0;                     // finished dwells no longer kept
  EarlierDwell earlier;
  std::uint64_t skipped_turns = 0;  // turns of the estimation thread that came too late and were left out
};

struct RunEvent {
  enum class Kind : std::uint8_t { state_changed, dwell_finished };
  Kind kind = Kind::state_changed;
  State before = State::idle;          // of state_changed: the state that ended
  std::shared_ptr<const Dwell> dwell;  // as it stands after the change, or as it ended; never null
  std::uint64_t lost = 0;              // events before this one for which there was no room
};

}  // namespace dwell
