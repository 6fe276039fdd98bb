// Keeps the newest samples, so that all of a hold can be fitted again when more is known of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/slices.hpp"

namespace dwell {

// A ring that overwrites the oldest samples. Bound to one thread; real-time safe except for the constructor.
class SampleHistory {
 public:
  struct Sample {
    std::int64_t t_ns;
    double value;  // SI
    int channel;
    bool held_up;  // the answer was held up on its way: the instant is less certain than usual
  };

  // slices: long work on the samples pauses in them (spend()); null: it never pauses. They must outlive this object.
  explicit SampleHistory(std::size_t capacity, Slices* slices = nullptr) : samples_(capacity), slices_(slices) {}

  void push(std::int64_t t_ns, int channel, double value, bool held_up = false) noexcept {
    samples_[next_] = {t_ns, value, channel, held_up};
    if (++next_ == samples_.size()) next_ = 0;
    ++end_;
  }
  // The samples held have the numbers [begin, end).
  [[nodiscard]] std::uint64_t begin() const noexcept { return end_ - std::min<std::uint64_t>(end_, samples_.size()); }
  [[nodiscard]] std::uint64_t end() const noexcept { return end_; }
  // The sample of that number; begin() <= number < end().
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

  // A pass over the samples reports its work here, in multiplications: after each sample, or after all samples of a
  // channel. The call may return much later. No sample is added meanwhile.
  void spend(double work) const noexcept {
    if (slices_ != nullptr) slices_->spend(work);
  }

 private:
  std::vector<Sample> samples_;
  std::uint64_t end_ = 0;
  std::size_t next_ = 0;  // where the next sample goes
  Slices* slices_;
};

}  // namespace dwell
