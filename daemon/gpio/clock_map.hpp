// From CLOCK_MONOTONIC, in which the kernel stamps edges, onto CLOCK_MONOTONIC_RAW, the axis of all records. NTP slews
// the former by up to 500 ppm, so the way between them is known only where both were read at once: between two such
// pairs it is a straight line. Pure but for read_clock_pair().
#pragma once

#include <cstdint>

namespace dwell::gpio {

struct ClockPair {
  std::int64_t raw_ns = 0;
  std::int64_t monotonic_ns = 0;  // of the same instant
  std::int64_t half_ns = 0;       // known to this
};

// Reads RAW, MONOTONIC, RAW some times over and keeps the narrowest: a preemption in between does not count.
[[nodiscard]] ClockPair read_clock_pair() noexcept;

class ClockMap {
 public:
  // Of increasing instants.
  void add(const ClockPair& pair) noexcept {
    before_ = known_ ? now_ : pair;
    now_ = pair;
    known_ = true;
  }
  [[nodiscard]] const ClockPair& now() const noexcept { return now_; }
  // Needs one pair; exact between the last two, elsewhere by the offset of the nearer one.
  [[nodiscard]] std::int64_t raw_ns(std::int64_t monotonic_ns) const noexcept {
    const std::int64_t span_ns = now_.monotonic_ns - before_.monotonic_ns;
    if (span_ns <= 0 || monotonic_ns >= now_.monotonic_ns) return monotonic_ns + offset_ns(now_);
    if (monotonic_ns <= before_.monotonic_ns) return monotonic_ns + offset_ns(before_);
    const double part = static_cast<double>(monotonic_ns - before_.monotonic_ns) / static_cast<double>(span_ns);
    const double change_ns = static_cast<double>(offset_ns(now_) - offset_ns(before_));
    return monotonic_ns + offset_ns(before_) + static_cast<std::int64_t>(part * change_ns);
  }

 private:
  static std::int64_t offset_ns(const ClockPair& pair) noexcept { return pair.raw_ns - pair.monotonic_ns; }
  ClockPair before_, now_;
  bool known_ = false;
};

}  // namespace dwell::gpio
