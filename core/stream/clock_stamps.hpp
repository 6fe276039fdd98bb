// Makes the stamps of a device's recovered clock: strictly increasing, with a half width that covers any doubt, and
// marked where readings before them were lost.
//
// Bound to one thread; real-time safe.
#pragma once

#include <cstdint>

#include "core/stream/held_arrivals.hpp"

namespace dwell {

class ClockStamps {
 public:
  // The clock was found: no reading is lost or in doubt yet.
  void begin() noexcept {
    doubt_ = 0.0;
    after_loss_ = false;
  }
  // Readings were lost before the next stamp.
  void lost() noexcept { after_loss_ = true; }
  // The numbering was just corrected by so many periods: the next stamp's half width grows by them.
  void doubt(double periods) noexcept { doubt_ = periods; }

  // Stamp of a reading without a recovered clock: its arrival.
  DeviceInstant arrived(std::int64_t arrival_ns) noexcept {
    last_ns_ = arrival_ns;
    return {arrival_ns, 0, false};
  }
  // Stamp of a reading by the recovered clock, at t_ns ± half_ns. A stamp not after the last one is moved behind it by
  // a sixteenth of a period, and its half width grows by the move.
  DeviceInstant recovered(std::int64_t t_ns, double half_ns, double period_ns) noexcept;

 private:
  double doubt_ = 0.0;  // periods
  bool after_loss_ = false;
  std::int64_t last_ns_ = 0;  // the last stamp given
};

}  // namespace dwell
