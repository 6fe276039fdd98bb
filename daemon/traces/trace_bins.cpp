#include "daemon/traces/trace_bins.hpp"

#include <algorithm>

namespace dwell {

void TraceBins::advance(std::int64_t number) noexcept {
  // After a leap in time longer than the ring every bin is emptied once.
  for (std::int64_t next = std::max(newest_ + 1, number - kBins + 1); next <= number; ++next)
    for (std::size_t channel = 0; channel < channels_; ++channel) bins_[place(channel, next)] = {};
  newest_ = std::max(newest_, number);
}

}  // namespace dwell
