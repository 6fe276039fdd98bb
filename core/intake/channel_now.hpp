// What the newest sample of a channel says, for displays. Plain data; LiveChannel keeps it, and fills in counts and
// condition where it hands it out.
#pragma once

#include <cstdint>

#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/stream/record.hpp"

namespace dwell {

struct ChannelNow {
  double value = kNaN;  // SI
  std::int64_t t_ns = 0;
  Fault fault = Fault::silent;  // none: it delivers
  bool overrange = false;       // the newest reading is beyond its range
  Condition condition = Condition::unheard;
  std::uint64_t used = 0;      // samples taken into account
  std::uint64_t rejected = 0;  // samples that were not: not finite, overrange, spikes, not after the one before
  std::uint64_t gaps = 0;      // times that samples were lost
};

}  // namespace dwell
