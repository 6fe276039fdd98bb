// The newest samples as they came, so that a hold can be gone over again once more is known of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/slices.hpp"

namespace dwell {

// A ring: the oldest are overwritten. Bound to one thread, real-time safe but for the constructor.
class SampleHistory {
 public:
  struct Sample {
    std::int64_t t_ns;
    double value;  // SI
    int channel;
  };

  // slices: in which it is gone over; null: in one. Must outlive this.
  explicit SampleHistory(std::size_t capacity, Slices* slices = nullptr) : samples_(capacity), slices_(slices) {}

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

  // Whoever goes over it says so: as many multiplications as were made for a sample, or for a channel when all samples
  // were gone over. May return much later; no sample is added meanwhile.
  void spend(double work) const noexcept {
    if (slices_ != nullptr) slices_->spend(work);
  }

 private:
  std::vector<Sample> samples_;
  std::uint64_t end_ = 0;
  std::size_t next_ = 0;  // where the next goes
  Slices* slices_;
};

}  // namespace dwell
