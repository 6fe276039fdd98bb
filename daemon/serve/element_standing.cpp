#include "daemon/serve/element_standing.hpp"

#include <algorithm>

namespace dwell {

const char* to_string(Standing standing) noexcept {
  switch (standing) {
    case Standing::valid:
      return "valid";
    case Standing::doubtful:
      return "doubtful";
    case Standing::not_settled:
      return "not settled";
    case Standing::not_identifiable:
      return "not identifiable";
    case Standing::stale:
      return "stale";
  }
  return "?";
}

bool is_stale(const ServiceView& now) noexcept {
  return now.health.status == Health::Status::fault || is_overdue(now.snapshot, now.now_ns);
}

Standing standing_of(const ServiceView& now, int k) noexcept {
  if (is_stale(now)) return Standing::stale;
  const Dwell& dwell = now.snapshot.dwell;
  if (dwell.state != State::measuring || dwell.elements.empty()) return Standing::not_settled;
  const ElementEstimate* const element = element_of(dwell, k);
  if (element == nullptr || !element->identifiable) return Standing::not_identifiable;
  const bool doubted =
      std::any_of(dwell.doubts.begin(), dwell.doubts.end(), [k](const Doubt& doubt) { return concerns(doubt, k); });
  return doubted ? Standing::doubtful : Standing::valid;
}

const ElementEstimate* element_to_hand_out(const ServiceView& now, int k) noexcept {
  const Standing standing = standing_of(now, k);
  return standing == Standing::valid || standing == Standing::doubtful ? element_of(now.snapshot.dwell, k) : nullptr;
}

}  // namespace dwell
