// Keeps the dwell that ended last until it is known why it ended.
//
// A drive that leaves its steady motion either changes or stops. Which of the two is known only after the change has
// passed through the window. Until then the dwell is kept back (DwellStates::awaits_reason()).
#pragma once

#include <cstdint>
#include <utility>

#include "core/result/dwell.hpp"

namespace dwell {

// Bound to one thread; keep() allocates, all else is real-time safe.
class FinishedDwell {
 public:
  // A dwell has ended. dwell: its last report; armed_ns: when it was armed; omega: of its drive, rad/s.
  void keep(Dwell dwell, std::int64_t armed_ns, double omega);
  // Waits for the reason, at most kLongestWait from now_serial on (Blocks::serials).
  void wait_for_reason(std::int64_t now_serial) noexcept { until_serial_ = now_serial + kLongestWait; }
  [[nodiscard]] bool waited_enough(std::int64_t serial) const noexcept { return serial >= until_serial_; }
  // The reason is known. false: no report, since it never settled and had hardly begun, and the run goes on.
  [[nodiscard]] bool conclude(EndedBy ended_by, std::int64_t now_ns) noexcept;

  [[nodiscard]] const Dwell& dwell() const noexcept { return dwell_; }

 private:
  static constexpr std::int64_t kLongestWait = 256;  // quarter periods
  static constexpr double kShortestTold = 5.0;       // periods: an unsettled dwell that is shorter is not reported

  Dwell dwell_;
  std::int64_t armed_ns_ = 0;
  double omega_ = 1.0;
  std::int64_t until_serial_ = 0;
};

}  // namespace dwell
