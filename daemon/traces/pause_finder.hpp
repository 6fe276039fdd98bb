// Tells where a channel's readings pause: the interval is more than 2.5 times as long as usual. Usual is the second
// longest of the 32 intervals before: one that is longer than all others, as where a reading is missing or after
// another pause, is not. Readings that come in bursts of up to 16 so pause nowhere.
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
  // The next reading, not before the last: whether there was a pause before it. Not told before the third interval.
  // O(32).
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
