// What the log says of one device: its channels go stale and come back, its faults go on. One place decides which line
// is written and which is only counted.
//
// Each kind of fault has a throttle of its own, so that a loose plug does not fill the log and a rare fault beside it
// is still told of. Occurrences are the caller's count since the beginning of the run, ever growing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/estimate/missed_polls.hpp"
#include "daemon/log/log.hpp"
#include "daemon/log/throttle.hpp"

namespace dwell {

// Bound to one thread, not real-time; the log must outlive it. Every instant is CLOCK_MONOTONIC_RAW.
class DeviceLines {
 public:
  // rate_hz: polls a second that the rig file asks for; 0: not known.
  DeviceLines(std::string device, double rate_hz, Log& log);

  // These channels went stale together, for that reason. occurrences: of that fault.
  void stale(const std::vector<std::string>& channels, Fault fault, const std::string& reason,
             std::uint64_t occurrences, std::int64_t now_ns);
  // These deliver. first: for the first time in this run; else stale_ns says for how long they had not.
  void delivering(const std::vector<std::string>& channels, bool first, std::int64_t stale_ns, std::int64_t now_ns);
  // Faults that made no channel stale, or go on: what no line has told of yet.
  void counted(Fault fault, std::uint64_t occurrences, std::int64_t now_ns);
  // A poll that is skipped now and then is counted and no news (MissedPolls).
  void missed_polls(std::uint64_t occurrences, std::int64_t now_ns);
  // The run ends: how many polls it skipped in all.
  void end(std::uint64_t missed_polls);

 private:
  void fault(Fault fault, std::uint64_t fresh, const std::string& words, std::uint64_t occurrences,
             std::int64_t now_ns);
  Throttle& throttle(Fault fault) { return throttles_[static_cast<std::size_t>(fault)]; }

  std::string device_;
  double rate_hz_;
  Log& log_;
  std::array<Throttle, kFaultCount> throttles_;    // by Fault; of none: recoveries
  std::array<std::uint64_t, kFaultCount> told_{};  // by Fault: occurrences when the last line was written
  MissedPolls polls_;
};

}  // namespace dwell
