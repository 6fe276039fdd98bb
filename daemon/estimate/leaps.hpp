// Whether a channel's readings span magnitudes that no transducer spans. Then the rig file states a wrong type or order
// of words: what is read is no number of the transducer.
#pragma once

#include <algorithm>
#include <cmath>

namespace dwell {

// Looks at readings in the device's units. A reading leaps if its size is 2^40 times that of the reading before, or the
// reverse. The finest converters resolve 2^32 of their range, and a float32 keeps 2^24 of its value. So no reading of a
// transducer is 2^40 times smaller than another, except an exact 0, which is passed over. A float32 in the wrong order
// of words takes its exponent from its last digits. Its size may be anything within 2^±126, and three of four readings
// leap. A lone spike leaps twice, and five spikes within a hundred readings are not enough.
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
  // Whether more than kMany of the last readings leapt; older ones count less, over kMemory readings.
  [[nodiscard]] bool found() const noexcept { return part_ > kMany; }

 private:
  static constexpr double kApart = 0x1p40;
  static constexpr double kMemory = 100.0;  // readings
  static constexpr double kMany = 0.1;      // part of the readings that leap
  double before_ = 0.0, part_ = 0.0;
};

}  // namespace dwell
