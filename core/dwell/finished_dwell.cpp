#include "core/dwell/finished_dwell.hpp"

#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"

namespace dwell {

void FinishedDwell::keep(Dwell dwell, std::int64_t armed_ns, double omega) {
  dwell_ = std::move(dwell);
  dwell_.state = State::complete;
  dwell_.settles_in_s = kNaN;
  armed_ns_ = armed_ns;
  omega_ = omega;
}

bool FinishedDwell::conclude(EndedBy ended_by, std::int64_t now_ns) noexcept {
  const bool hardly_begun = to_s(now_ns - armed_ns_) < kShortestTold * kTwoPi / omega_;
  if (!std::isfinite(dwell_.settled_s) && ended_by != EndedBy::end && hardly_begun) return false;
  dwell_.ended_by = ended_by;
  return true;
}

}  // namespace dwell
