// Sync pulses that fit no train: the newest few wait here until they are in step with each other and begin one.
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
  // low_hz, high_hz: between which the drive is looked for.
  TrainBegin(double low_hz, double high_hz) noexcept;

  // Another pulse that fits nothing. Whether the oldest had to go for it.
  bool add(std::int64_t t_ns) noexcept;
  // The period of those that wait, s; none: they are too few, not in step, or of no drive that is looked for.
  [[nodiscard]] std::optional<double> period_s() const noexcept;
  // Those that wait, oldest first.
  [[nodiscard]] std::span<const std::int64_t> pulses() const noexcept { return {waiting_.data(), count_}; }
  void clear() noexcept { count_ = 0; }

 private:
  static constexpr std::size_t kBegin = 4;  // pulses in step that begin a train

  double shortest_s_, longest_s_;  // intervals that can be a period
  std::array<std::int64_t, kBegin> waiting_{};
  std::size_t count_ = 0;
};

}  // namespace dwell
