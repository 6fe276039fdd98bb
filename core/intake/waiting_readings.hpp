// Readings that wait: whether they belong to the motion is not decided yet.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace dwell {

struct DatedReading {
  std::int64_t t_ns = 0;
  double value = 0.0;
  std::uint32_t half_ns = 0;
  std::uint32_t refresh_half_ns = 0;  // ns, of a held register: its refresh came at t_ns ± this
};

// Of one channel. One thread; real-time safe.
class WaitingReadings {
 public:
  static constexpr std::size_t kMost = 3;

  void add(const DatedReading& reading) noexcept { readings_[count_++] = reading; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  // The oldest of those that wait, or waited last.
  [[nodiscard]] std::span<const DatedReading> first(std::size_t count) const noexcept {
    return {readings_.data(), count};
  }
  // None waits any longer. Those that waited, the oldest first; valid until the next add().
  std::span<const DatedReading> take() noexcept { return {readings_.data(), std::exchange(count_, 0)}; }
  // Whether the readings that wait, at least two, and `next` go on evenly: on a line to within `limit`, or with
  // differences that change by no more than half.
  [[nodiscard]] bool goes_on_evenly(const DatedReading& next, double limit) const noexcept {
    const double before = readings_[count_ - 1].value - readings_[count_ - 2].value,
                 after = next.value - readings_[count_ - 1].value;
    return std::abs(after - before) <= std::max(limit, 0.5 * (std::abs(after) + std::abs(before)));
  }

 private:
  std::array<DatedReading, kMost> readings_{};
  std::size_t count_ = 0;
};

}  // namespace dwell
