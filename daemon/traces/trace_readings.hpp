// The newest readings of one channel, each with its instant: bins finer than 20 ms are made of them. A ring of fixed
// length.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>

namespace dwell {

// Bound to one thread; allocates in the constructor alone.
class TraceReadings {
 public:
  // 600 s at 1 kHz.
  static constexpr std::size_t kMost = 600'000;
  static constexpr std::size_t kBytesEach = sizeof(std::int64_t) + sizeof(float);

  // capacity: readings kept, at least 1.
  explicit TraceReadings(std::size_t capacity)
      : capacity_(capacity),
        t_ns_(std::make_unique_for_overwrite<std::int64_t[]>(capacity)),  // untouched pages take no memory
        value_(std::make_unique_for_overwrite<float[]>(capacity)) {}

  // In the order of their instants. value: in the channel's unit; NaN: a reading is missing here.
  void push(std::int64_t t_ns, float value) noexcept {
    const std::size_t place = taken_++ % capacity_;
    t_ns_[place] = t_ns;
    value_[place] = value;
  }
  // All readings from this instant on are still there.
  [[nodiscard]] std::int64_t oldest_ns() const noexcept {
    return taken_ <= capacity_ ? std::numeric_limits<std::int64_t>::min() : t_ns_[taken_ % capacity_];
  }
  // Calls each(t_ns, value) for the readings of from_ns <= t < to_ns. O(log kept + readings).
  template <class Each>
  void between(std::int64_t from_ns, std::int64_t to_ns, Each each) const {
    std::size_t low = taken_ - std::min(taken_, capacity_), high = taken_;
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (t_ns_[middle % capacity_] < from_ns)
        low = middle + 1;
      else
        high = middle;
    }
    for (; low < taken_ && t_ns_[low % capacity_] < to_ns; ++low) each(t_ns_[low % capacity_], value_[low % capacity_]);
  }

 private:
  std::size_t capacity_;
  std::unique_ptr<std::int64_t[]> t_ns_;
  std::unique_ptr<float[]> value_;
  std::size_t taken_ = 0;
};

}  // namespace dwell
