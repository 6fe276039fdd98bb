// Tells where a channel's readings pause: where an interval is more than 2.5 times the usual one. One missing reading
// makes two intervals of one and is bridged, two make three and are told. An export draws the line there too
// (Resampler::kGap).
//
// The usual interval is the second longest of the last 32. So one outlier, such as an earlier pause, does not count,
// and readings in bursts of up to 16 never pause: two of the 32 are the long intervals between bursts. After two pauses
// within 32 readings a third one is told only if it is 2.5 times as long as the shorter of the two.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace dwell {

// A value; bound to one thread. Real-time safe.
class PauseFinder {
 public:
  // Whether there was a pause before the next reading, whose t_ns must not decrease. Always false for the first two
  // intervals. O(32).
  [[nodiscard]] bool paused_before(std::int64_t t_ns) noexcept {
    const std::int64_t last_ns = std::exchange(last_ns_, t_ns);
    if (last_ns == kNone) return false;
    const std::int64_t interval_ns = t_ns - last_ns, usual_ns = second_longest();
    intervals_ns_[count_++ % intervals_ns_.size()] = interval_ns;
    return usual_ns > 0 && 2 * interval_ns > 5 * usual_ns;
  }

 private:
  static constexpr std::int64_t kNone = INT64_MIN;

  [[nodiscard]] std::int64_t second_longest() const noexcept {
    std::int64_t longest = 0, second = 0;
    for (const std::int64_t interval_ns : intervals_ns_) {
      second = std::max(second, std::min(longest, interval_ns));
      longest = std::max(longest, interval_ns);
    }
    return second;
  }

  std::array<std::int64_t, 32> intervals_ns_{};  // the newest; 0: none yet
  std::size_t count_ = 0;
  std::int64_t last_ns_ = kNone;
};

}  // namespace dwell
