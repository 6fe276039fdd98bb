// Knows how often the readings of a channel come, and for how long they have been one and the same number.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe.
class ReadingTimes {
 public:
  // The next reading. Returns the number before it (NAN: this is the first).
  double add(std::int64_t t_ns, double raw) noexcept {
    const double before = number_;
    ++count_;
    if (first_ns_ == INT64_MIN) first_ns_ = t_ns;
    newest_ns_ = t_ns;
    ++same_;
    if (raw != number_) {
      changed_ns_ = t_ns;
      same_ = 0;
    }
    number_ = raw;
    return before;
  }
  // So many readings, each other than the one before; the last of them.
  void add_different(std::size_t readings, std::int64_t last_ns, double last) noexcept {
    count_ += readings;
    newest_ns_ = changed_ns_ = last_ns;
    same_ = 0;
    number_ = last;
  }
  // The newest reading; NAN: there is none.
  [[nodiscard]] double newest() const noexcept { return number_; }
  [[nodiscard]] bool heard() const noexcept { return newest_ns_ != INT64_MIN; }
  // Readings since the restart.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  // Mean time between two readings. The division is made only if seconds are asked for.
  struct MeanInterval {
    std::int64_t span_ns = 0;     // 0: not known
    std::uint64_t intervals = 0;  // in span_ns
    [[nodiscard]] double s() const noexcept {
      return span_ns > 0 ? 1e-9 * static_cast<double>(span_ns) / static_cast<double>(intervals) : 0.0;
    }
  };
  [[nodiscard]] MeanInterval mean_interval() const noexcept {
    return count_ > 1 ? MeanInterval{newest_ns_ - first_ns_, count_ - 1} : MeanInterval{};
  }
  // The mean interval, s; 0: not known.
  [[nodiscard]] double interval_s() const noexcept { return mean_interval().s(); }
  // Whether the newest reading equals the one before.
  [[nodiscard]] bool repeats() const noexcept { return changed_ns_ != newest_ns_; }
  // How long the equal readings lasted if each lasted a mean interval, s: a pause between two adds nothing.
  [[nodiscard]] double read_same_s() const noexcept { return static_cast<double>(same_) * interval_s(); }
  // For how long the reading has been the same, s.
  [[nodiscard]] double same_for_s() const noexcept {
    return changed_ns_ == INT64_MIN ? 0.0 : 1e-9 * static_cast<double>(newest_ns_ - changed_ns_);
  }
  void restart() noexcept {
    first_ns_ = INT64_MIN;
    count_ = 0;
  }

 private:
  double number_ = NAN;
  std::int64_t newest_ns_ = INT64_MIN, changed_ns_ = INT64_MIN, first_ns_ = INT64_MIN;
  std::uint64_t count_ = 0, same_ = 0;  // readings; those that equal the one before
};

}  // namespace dwell
