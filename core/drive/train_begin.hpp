// Finds the beginning of a train: sync pulses that fit no train wait here until the newest few are evenly spaced.
// Bound to one thread; real-time safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace dwell {

class TrainBegin {
 public:
  // low_hz, high_hz: the range in which the drive is searched.
  TrainBegin(double low_hz, double high_hz) noexcept;

  // Takes another pulse that fits no train. True: the oldest one was dropped for it.
  bool add(std::int64_t t_ns) noexcept;
  // Period of the waiting pulses, s. None: they are too few, not evenly spaced, or outside the search range.
  [[nodiscard]] std::optional<double> period_s() const noexcept;
  // The waiting pulses, oldest first.
  [[nodiscard]] std::span<const std::int64_t> pulses() const noexcept { return {waiting_.data(), count_}; }
  void clear() noexcept { count_ = 0; }

 private:
  static constexpr std::size_t kBegin = 4;  // evenly spaced pulses that begin a train

  double shortest_s_, longest_s_;  // intervals that can be a period
  std::array<std::int64_t, kBegin> waiting_{};
  std::size_t count_ = 0;
};

}  // namespace dwell
