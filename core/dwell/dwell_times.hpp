// The instants of the run and of the dwell that is on, of the stream. Plain data.
#pragma once

#include <cstdint>

namespace dwell {

struct DwellTimes {
  std::int64_t origin_ns = INT64_MIN;       // where the run's axis of time begins; INT64_MIN: nothing has come yet
  std::int64_t last_sample_ns = INT64_MIN;  // of the newest sample of any channel
  std::int64_t armed_ns = 0;                // since when a drive is looked at that has not settled
  std::int64_t start_ns = 0;                // when its last hold began: what is reported as the dwell's start
  std::int64_t steady_ns = 0;               // since when the drive is taken as steady
  std::int64_t settled_ns = 0;              // the data count from here on
  std::int64_t verdict_ns = 0;              // when that was first said
  std::int64_t steady_serial = 0;           // the quarter block that begins at steady_ns (Blocks::serials)
};

}  // namespace dwell
