#include "core/result/dwell.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {

const char* to_string(CoefficientKind kind) noexcept {
  return kind == CoefficientKind::stiffness ? "stiffness" : "damping";
}

const char* to_string(State state) noexcept {
  switch (state) {
    case State::idle:
      return "idle";
    case State::settling:
      return "settling";
    case State::measuring:
      return "measuring";
    case State::complete:
      return "complete";
    case State::fault:
      return "fault";
  }
  return "unknown";
}

const char* to_string(EndedBy ended_by) noexcept {
  switch (ended_by) {
    case EndedBy::none:
      return "none";
    case EndedBy::drive_changed:
      return "drive changed";
    case EndedBy::drive_stopped:
      return "drive stopped";
    case EndedBy::interlock:
      return "interlock";
    case EndedBy::data_lost:
      return "data lost";
    case EndedBy::end:
      return "end";
    case EndedBy::rearmed:
      return "re-armed";
  }
  return "unknown";
}

const ElementEstimate* element_of(const Dwell& dwell, int k) noexcept {
  const auto found =
      std::find_if(dwell.elements.begin(), dwell.elements.end(), [k](const ElementEstimate& e) { return e.k == k; });
  return found == dwell.elements.end() ? nullptr : &*found;
}

bool has_coefficients(const Dwell& dwell) noexcept { return std::isfinite(dwell.settled_s) && !dwell.elements.empty(); }

bool concerns(const Doubt& doubt, int k) noexcept {
  return doubt.elements.empty() || std::find(doubt.elements.begin(), doubt.elements.end(), k) != doubt.elements.end();
}

bool trustworthy(const Dwell& dwell) noexcept {
  return std::isfinite(dwell.settled_s) && dwell.doubts.empty() && !dwell.elements.empty() &&
         std::all_of(dwell.elements.begin(), dwell.elements.end(),
                     [](const ElementEstimate& element) { return element.identifiable; });
}

}  // namespace dwell
