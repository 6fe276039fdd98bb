// Whether a channel's readings span magnitudes that no transducer spans: then it is no number of its transducer that is
// read, but a register of another type or order of words.
#pragma once

#include <algorithm>
#include <cmath>

namespace dwell {

// Looks at readings as the device gives them. A reading leaps if its size is 2^40 times that of the reading before, or
// the reverse. The finest converters resolve 2^32 of their range, and a float32 keeps 2^24 of its value; so no reading
// of a transducer but an exact 0 is 2^40 times smaller than another. A float32 in the wrong order of words takes its
// exponent from its last digits: any of 2^±126, and three of four readings leap. A lone spike leaps twice, and five
// within a hundred readings are not enough.
//
// Bound to one thread; see() is real-time safe and O(1).
class Leaps {
 public:
  void see(double raw) noexcept {
    const double size = std::abs(raw);
    if (!(size > 0.0) || !std::isfinite(size)) return;
    const bool leaps = before_ > 0.0 && std::max(size, before_) > kApart * std::min(size, before_);
    part_ += ((leaps ? 1.0 : 0.0) - part_) / kMemory;
    before_ = size;
  }
  [[nodiscard]] bool found() const noexcept { return part_ > kMany; }

 private:
  static constexpr double kApart = 0x1p40;
  static constexpr double kMemory = 100.0;  // readings
  static constexpr double kMany = 0.1;      // part of them
  double before_ = 0.0, part_ = 0.0;
};

}  // namespace dwell
