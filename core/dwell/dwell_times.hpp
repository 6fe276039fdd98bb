// The instants of the run and of the present dwell, on the stream's clock. Plain data.
#pragma once

#include <cstdint>

namespace dwell {

struct DwellTimes {
  std::int64_t origin_ns = INT64_MIN;       // beginning of the run's time axis; INT64_MIN: no record yet
  std::int64_t last_sample_ns = INT64_MIN;  // newest sample of any channel
  std::int64_t armed_ns = 0;                // when the present dwell was armed
  std::int64_t start_ns = 0;         // beginning of its last hold before the verdict: reported as the dwell's start
  std::int64_t steady_ns = 0;        // beginning of the present hold
  std::int64_t settled_ns = 0;       // the data count from here on
  std::int64_t verdict_ns = 0;       // when the verdict was given
  std::int64_t lost_ns = INT64_MIN;  // when the drive's channel was last found not to deliver; INT64_MIN: never
  std::int64_t steady_serial = 0;    // the quarter block that begins at steady_ns (Blocks::serials)
};

}  // namespace dwell
