// From readings of any motion to coefficients with their uncertainty: maximum likelihood on the exact chain, the table
// an unknown process. Ramps, knocks of the table, start-up, random motion, a drive that wanders, and dwells with their
// transient. docs/method.md, Any motion.
#pragma once

#include <cstddef>
#include <stop_token>
#include <string>
#include <vector>

#include "core/motion/likelihood.hpp"
#include "core/result/condition.hpp"
#include "core/result/motion.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct MotionOptions {
  // Most readings taken, from the start of the motion on, times the states of the model: bounds the time of an
  // estimate. 70 000 readings of a table and two masses; some 2 s where scans repeat, 20 s where they come irregularly.
  std::size_t most_work = 500'000;
  // Whether to look for what the rig file lacks: a third of the time more on a healthy rig.
  bool missing = true;
  // Whether that search may fit the chain anew where the readings contradict it, which takes ten times as long. false:
  // it is put off, and reason or warnings say so.
  bool anew = true;
  // Channels whose readings are at fault. If there are any, the search for what the rig file lacks is skipped, and the
  // estimate says so. The search would explain faulty readings by terms of the rig, and takes ten times as long.
  std::vector<ChannelFault> at_fault{};
  std::stop_token stop{};
};

// data.readings: by time, t_ns less each channel's stated delay; data.stretches: none. Where the readings do not carry
// an estimate, `reason` says why. Thread-safe; allocates, takes seconds. Throws Stopped some passes over the readings
// after options.stop was requested, if it does not end before.
[[nodiscard]] MotionEstimate estimate_motion(const Rig& rig, const MotionData& data, const MotionOptions& options = {});

}  // namespace dwell
