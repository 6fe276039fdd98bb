#include "core/stream/clock_stamps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dwell {

DeviceInstant ClockStamps::recovered(std::int64_t t_ns, double half_ns, double period_ns) noexcept {
  if (doubt_ > 0.0) half_ns += std::exchange(doubt_, 0.0) * period_ns;
  if (t_ns <= last_ns_) {
    const std::int64_t forced_ns = last_ns_ + std::max<std::int64_t>(1, std::llround(period_ns / 16.0));
    half_ns += static_cast<double>(forced_ns - t_ns);
    t_ns = forced_ns;
  }
  last_ns_ = t_ns;
  return {t_ns, static_cast<std::uint32_t>(std::min(half_ns, 4e9)), std::exchange(after_loss_, false)};
}

}  // namespace dwell
