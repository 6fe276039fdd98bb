// Counts the foreign readings of a channel, and knows their commonest number.
#pragma once

#include <cstdint>

namespace dwell {

// Of one channel, in any unit. One thread; real-time safe.
class ForeignReadings {
 public:
  // repeat: the channel showed this number a moment before.
  void add(double value, bool repeat) noexcept {
    ++all_;
    ++of_all_time_;
    if (repeat) ++repeats_;
    // The commonest value by majority vote (Boyer and Moore).
    if (value == value_) {
      ++commonest_;
    } else if (commonest_ <= 1) {
      value_ = value;
      commonest_ = 1;
    } else if (!repeat) {
      --commonest_;
    }
  }
  // Since the restart: all foreign readings, and those that repeat an older one.
  [[nodiscard]] std::uint64_t all() const noexcept { return all_; }
  [[nodiscard]] std::uint64_t repeats() const noexcept { return repeats_; }
  [[nodiscard]] std::uint64_t of_all_time() const noexcept { return of_all_time_; }
  // Whether two or more foreign readings have the number value().
  [[nodiscard]] bool cluster() const noexcept { return commonest_ >= 2; }
  [[nodiscard]] double value() const noexcept { return value_; }
  // Counts begin anew; the commonest number stays known.
  void restart() noexcept { all_ = repeats_ = commonest_ = 0; }

 private:
  std::uint64_t all_ = 0, repeats_ = 0, commonest_ = 0, of_all_time_ = 0;
  double value_ = 0.0;
};

}  // namespace dwell
