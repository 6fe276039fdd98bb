#include "daemon/serve/element_standing.hpp"

#include <algorithm>

namespace dwell {
namespace {

const ElementEstimate* element_of(const Dwell& dwell, int k) noexcept {
  const auto found =
      std::find_if(dwell.elements.begin(), dwell.elements.end(), [k](const ElementEstimate& e) { return e.k == k; });
  return found == dwell.elements.end() ? nullptr : &*found;
}

bool is_doubted(const Dwell& dwell, int k) noexcept {
  return std::any_of(dwell.doubts.begin(), dwell.doubts.end(), [k](const Doubt& doubt) {
    return doubt.elements.empty() || std::find(doubt.elements.begin(), doubt.elements.end(), k) != doubt.elements.end();
  });
}

}  // namespace

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
  return now.health.status == Health::Status::fault || is_overdue(now.rig, now.snapshot, now.now_ns);
}

Standing standing_of(const ServiceView& now, int k) noexcept {
  if (is_stale(now)) return Standing::stale;
  const Dwell& dwell = now.snapshot.dwell;
  if (dwell.state != State::measuring || dwell.elements.empty()) return Standing::not_settled;
  const ElementEstimate* const element = element_of(dwell, k);
  if (element == nullptr || !element->identifiable) return Standing::not_identifiable;
  return is_doubted(dwell, k) ? Standing::doubtful : Standing::valid;
}

const ElementEstimate* element_to_hand_out(const ServiceView& now, int k) noexcept {
  const Standing standing = standing_of(now, k);
  return standing == Standing::valid || standing == Standing::doubtful ? element_of(now.snapshot.dwell, k) : nullptr;
}

}  // namespace dwell
