// The stamps that a device's clock gives out: each after the one before, as wide as what is in doubt about it, and
// marked where readings before it were lost.
//
// Bound to one thread; real-time safe.
#pragma once

#include <cstdint>

#include "core/stream/held_arrivals.hpp"

namespace dwell {

class ClockStamps {
 public:
  // The clock was found: nothing is lost or in doubt yet.
  void begin() noexcept {
    doubt_ = 0.0;
    after_loss_ = false;
  }
  // Readings were lost before the next stamp.
  void lost() noexcept { after_loss_ = true; }
  // The numbering was just put right by so many periods: the next stamp is in doubt by these.
  void doubt(double periods) noexcept { doubt_ = periods; }

  // The stamp of a reading whose arrival stands.
  DeviceInstant arrived(std::int64_t arrival_ns) noexcept {
    last_ns_ = arrival_ns;
    return {arrival_ns, 0, false};
  }
  // That of a reading of the recovered clock, at t_ns ± half_ns.
  DeviceInstant recovered(std::int64_t t_ns, double half_ns, double period_ns) noexcept;

 private:
  double doubt_ = 0.0;  // periods
  bool after_loss_ = false;
  std::int64_t last_ns_ = 0;  // the stamp given last
};

}  // namespace dwell
