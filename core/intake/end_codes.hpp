// Is a number the end of an integer type, or a code for "no value", as converters and gateways send them? It is where
// nothing has been read beyond it.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>

namespace dwell {

// Of one channel, in the device's own numbers. Bound to one thread; real-time safe.
class EndCodes {
 public:
  [[nodiscard]] bool has(double raw) const noexcept {
    if (!(raw > largest_ || raw < smallest_)) return false;
    return std::find(std::begin(kCodes), std::end(kCodes), raw) != std::end(kCodes);
  }
  // A reading that is none.
  void see(double raw) noexcept {
    largest_ = std::max(largest_, raw);
    smallest_ = std::min(smallest_, raw);
  }
  // The largest size of a reading that is none.
  [[nodiscard]] double largest() const noexcept { return std::max(std::abs(largest_), std::abs(smallest_)); }

 private:
  static constexpr double kCodes[] = {32767.0,      -32768.0,      65535.0,      32768.0,
                                      2147483647.0, -2147483648.0, 4294967295.0, 2147483648.0};
  double largest_ = -INFINITY, smallest_ = INFINITY;
};

}  // namespace dwell
