// Gathers the records of the stream as readings of a motion: in SI, at the instants of the motion (each stamp less its
// channel's stated delay), without those that are no numbers or beyond the range of their channel.
#pragma once

#include <cstddef>
#include <vector>

#include "core/intake/device_numbers.hpp"
#include "core/motion/likelihood.hpp"
#include "core/stream/record.hpp"

namespace dwell {

class MotionRecorder {
 public:
  explicit MotionRecorder(const Rig& rig);

  // Any record; others than samples of channels that count are passed over. Allocates now and then.
  void take(const Record& record);
  [[nodiscard]] std::size_t size() const noexcept { return readings_.size(); }
  // By time.
  [[nodiscard]] MotionData data() const;

 private:
  struct Line {
    DeviceNumbers numbers;
    std::int64_t delay_ns;
    bool counts;
  };
  std::vector<Line> lines_;
  std::vector<MotionReading> readings_;
};

}  // namespace dwell
