// The dwell that ended last, and why it did.
//
// A drive that leaves its steady motion either changes or stops, and which of the two shows only when the change has
// passed through the window. Until then the finished dwell is kept back (DwellStates::awaits_reason()).
#pragma once

#include <cstdint>
#include <utility>

#include "core/result/dwell.hpp"

namespace dwell {

// Bound to one thread; keep() allocates, all else is real-time safe.
class FinishedDwell {
 public:
  // A dwell has ended, for a reason not known yet: as it was reported last, at now_ns it had been armed since armed_ns,
  // its drive at omega (rad/s).
  void keep(Dwell dwell, std::int64_t armed_ns, double omega);
  // The reason is waited for until that many quarter periods have been seen.
  void wait_for_reason(std::int64_t now_serial) noexcept { until_serial_ = now_serial + kLongestWait; }
  [[nodiscard]] bool waited_enough(std::int64_t serial) const noexcept { return serial >= until_serial_; }
  // The reason is known. false: the dwell is not told, for it never settled and was hardly begun.
  [[nodiscard]] bool conclude(EndedBy ended_by, std::int64_t now_ns) noexcept;

  [[nodiscard]] const Dwell& dwell() const noexcept { return dwell_; }

 private:
  static constexpr std::int64_t kLongestWait = 256;  // quarters that it is kept back
  static constexpr double kShortestTold = 5.0;       // periods: what ended sooner without settling is not told

  Dwell dwell_;
  std::int64_t armed_ns_ = 0;
  double omega_ = 1.0;
  std::int64_t until_serial_ = 0;
};

}  // namespace dwell
