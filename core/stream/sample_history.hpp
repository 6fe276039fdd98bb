// The newest samples as they came, so that a hold can be gone over again once more is known of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dwell {

// A ring: the oldest are overwritten. Bound to one thread, real-time safe but for the constructor.
class SampleHistory {
 public:
  struct Sample {
    std::int64_t t_ns;
    double value;  // SI
    int channel;
  };

  explicit SampleHistory(std::size_t capacity) : samples_(capacity) {}

  void push(std::int64_t t_ns, int channel, double value) noexcept {
    samples_[next_] = {t_ns, value, channel};
    if (++next_ == samples_.size()) next_ = 0;
    ++end_;
  }
  // Numbers of the samples held: [begin, end).
  [[nodiscard]] std::uint64_t begin() const noexcept { return end_ - std::min<std::uint64_t>(end_, samples_.size()); }
  [[nodiscard]] std::uint64_t end() const noexcept { return end_; }
  // begin() <= number < end().
  [[nodiscard]] const Sample& operator[](std::uint64_t number) const noexcept {
    const auto ago = static_cast<std::size_t>(end_ - number);
    return samples_[ago <= next_ ? next_ - ago : next_ + samples_.size() - ago];
  }
  // Number of the first sample held at or after t. O(log n).
  [[nodiscard]] std::uint64_t first_at(std::int64_t t_ns) const noexcept {
    std::uint64_t low = begin(), high = end();
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      if ((*this)[middle].t_ns < t_ns)
        low = middle + 1;
      else
        high = middle;
    }
    return low;
  }

 private:
  std::vector<Sample> samples_;
  std::uint64_t end_ = 0;
  std::size_t next_ = 0;  // where the next goes
};

}  // namespace dwell
