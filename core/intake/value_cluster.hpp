// Finds one number that makes up far too many readings wherever the motion is: zeros of a gateway, a "no value" code.
//
// The candidate comes from readings that repeat one of the last eight. It is a cluster if it makes up more than kPart
// of the readings and follows readings from all over the range. The range must be kLevels rounding steps or more. A
// sine of that range with noise has at most 2 % of its readings at one number, at the crest. The readings before these
// are near the crest, also where sampling at a whole fraction of the period repeats every number.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/intake/recent_numbers.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class ValueCluster {
 public:
  // The next reading and the one before it.
  void add(double reading, double before) noexcept {
    ++seen_;
    low_ = std::min(low_, reading);
    high_ = std::max(high_, reading);
    if (!recent_.has(reading)) {
      recent_.add(reading);
    } else if (reading != value_ && --votes_ < 0) {
      *this = ValueCluster(*this, reading);
    }
    if (reading != value_) return;
    ++votes_;
    ++count_;
    if (before == value_) return;
    from_low_ = std::min(from_low_, before);
    from_high_ = std::max(from_high_, before);
  }
  // Whether it remembers exactly these eight readings, the oldest first.
  [[nodiscard]] bool remembers(std::span<const double, 8> readings) const noexcept { return recent_.are(readings); }
  // Readings that equal neither the candidate nor one of the eight before; their range.
  void add_new(std::span<const double> readings, double low, double high) noexcept {
    seen_ += static_cast<std::int64_t>(readings.size());
    low_ = std::min(low_, low);
    high_ = std::max(high_, high);
    recent_.add_all(readings);
  }
  [[nodiscard]] double value() const noexcept { return value_; }
  // Its part of the readings since it became the candidate.
  [[nodiscard]] double part() const noexcept { return static_cast<double>(count_) / static_cast<double>(seen_); }
  [[nodiscard]] bool found(double step) const noexcept {
    const double range = high_ - low_;
    return count_ >= kFewest && part() > kPart && from_high_ - from_low_ > kAllOver * range && range > kLevels * step;
  }
  void restart() noexcept { *this = {}; }
  ValueCluster() = default;

 private:
  static constexpr double kPart = 0.05, kAllOver = 0.5, kLevels = 1000.0;
  static constexpr std::int64_t kFewest = 20;
  ValueCluster(const ValueCluster& before, double value) noexcept
      : recent_(before.recent_), low_(before.low_), high_(before.high_), value_(value), seen_(1) {}

  RecentNumbers<8> recent_;
  double low_ = INFINITY, high_ = -INFINITY, from_low_ = INFINITY, from_high_ = -INFINITY, value_ = NAN;
  std::int64_t seen_ = 0, count_ = 0, votes_ = 0;
};

}  // namespace dwell
