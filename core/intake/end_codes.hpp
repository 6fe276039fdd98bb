// Recognizes codes for "no value" that converters and gateways send: the ends of integer types. Such a number is a code
// only if it lies beyond all good readings so far.
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
  // Whether the reading lies between good ones. Then it is one as well, and see() changes nothing.
  [[nodiscard]] bool amid(double raw) const noexcept { return raw <= largest_ && raw >= smallest_; }
  // Takes in a reading that is no code.
  void see(double raw) noexcept {
    largest_ = std::max(largest_, raw);
    smallest_ = std::min(smallest_, raw);
  }
  // The good readings so far.
  [[nodiscard]] double highest() const noexcept { return largest_; }
  [[nodiscard]] double lowest() const noexcept { return smallest_; }
  // The largest magnitude of the readings that are no codes.
  [[nodiscard]] double largest() const noexcept { return std::max(std::abs(largest_), std::abs(smallest_)); }

 private:
  static constexpr double kCodes[] = {32767.0,      -32768.0,      65535.0,      32768.0,
                                      2147483647.0, -2147483648.0, 4294967295.0, 2147483648.0};
  double largest_ = -INFINITY, smallest_ = INFINITY;
};

}  // namespace dwell
