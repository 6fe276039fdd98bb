#include "daemon/gpio/clock_map.hpp"

#include "daemon/clock.hpp"

namespace dwell::gpio {

ClockPair read_clock_pair() noexcept {
  constexpr int kTries = 5;
  ClockPair best;
  for (int i = 0; i < kTries; ++i) {
    const std::int64_t before_ns = raw_now_ns();
    const std::int64_t monotonic_ns = read_clock_ns(CLOCK_MONOTONIC);
    const std::int64_t after_ns = raw_now_ns();
    const std::int64_t half_ns = (after_ns - before_ns + 1) / 2;
    if (i == 0 || half_ns < best.half_ns) best = {before_ns + half_ns, monotonic_ns, half_ns};
  }
  return best;
}

}  // namespace dwell::gpio
