// What the newest sample of a channel shows, for displays. Plain data. LiveChannel keeps it and adds counts and
// condition when asked.
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
  std::uint64_t used = 0;  // samples used
  // Samples not used: not finite, overrange, spikes, not after the one before, or with too uncertain an instant.
  std::uint64_t rejected = 0;
  std::uint64_t gaps = 0;  // how often samples were lost
};

}  // namespace dwell
