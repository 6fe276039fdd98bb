// What the table did in a recording in which no dwell was found, so that the answer can say it: how far and how fast it
// moved, for how long, how steadily. It looks at the table's readings alone and is no part of the method: its numbers
// are for a sentence.
#pragma once

#include <string>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "daemon/ctl/record_source.hpp"

namespace dwell::ctl {

struct TableMotion {
  std::string channel;         // the first that measures the table; empty: none does
  double amplitude = kNaN;     // the largest, of the displacement, m or rad
  double frequency_hz = kNaN;  // in the longest stretch of motion above the minimum; NaN: none long enough to tell
  double moving_s = 0.0;       // length of that stretch
  double wander = kNaN;        // least change of the amplitude from two periods to the next two in it, relative
};

// Cost: three passes over the recording; memory does not grow with it. Readings that are not finite or beyond the
// channel's range do not count. If the recording has a mistake, only the readings before it count.
[[nodiscard]] TableMotion table_motion(const Rig& rig, const RecordSource& source);

// One sentence: what was seen, what was expected.
[[nodiscard]] std::string why_no_dwell(const Rig& rig, const TableMotion& motion);

}  // namespace dwell::ctl
