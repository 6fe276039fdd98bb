#include "core/dwell.hpp"

namespace dwell {

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
  }
  return "unknown";
}

}  // namespace dwell
