// Converts a channel's own numbers into SI and into the rig file's unit, and knows its range.
#pragma once

#include <cmath>
#include <string>

#include "core/base/wording.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Immutable; thread-safe. All but text() is real-time safe.
class DeviceNumbers {
 public:
  explicit DeviceNumbers(const Channel& channel)
      : gain_(channel.si_per_unit * channel.scale),
        offset_(channel.si_per_unit * channel.offset),
        low_(channel.range.low.value_or(-INFINITY) * channel.si_per_unit),
        high_(channel.range.high.value_or(INFINITY) * channel.si_per_unit),
        si_per_unit_(channel.si_per_unit),
        unit_(unit_text(channel.unit)) {}

  [[nodiscard]] double si(double raw) const noexcept { return gain_ * raw + offset_; }
  // The absolute difference of two numbers in SI, and back.
  [[nodiscard]] double si_of_difference(double raw) const noexcept { return std::abs(gain_) * raw; }
  [[nodiscard]] double difference_of_si(double si) const noexcept { return si / std::abs(gain_); }
  [[nodiscard]] bool beyond_range(double raw) const noexcept { return si(raw) < low_ || si(raw) > high_; }
  // "3.2 mm"
  [[nodiscard]] std::string text(double raw) const { return brief(si(raw) / si_per_unit_, 6) + " " + unit_; }

 private:
  double gain_, offset_, low_, high_;  // SI
  double si_per_unit_;
  std::string unit_;
};

}  // namespace dwell
