#include "core/stream/record.hpp"

namespace dwell {

const char* to_string(Fault fault) noexcept {
  switch (fault) {
    case Fault::none:
      return "none";
    case Fault::disconnected:
      return "disconnected";
    case Fault::timeout:
      return "timeout";
    case Fault::exception:
      return "exception";
    case Fault::bad_checksum:
      return "bad checksum";
    case Fault::short_frame:
      return "short frame";
    case Fault::bad_frame:
      return "bad frame";
    case Fault::late_answer:
      return "late answer";
    case Fault::invalid_value:
      return "invalid value";
    case Fault::missed_deadline:
      return "missed deadline";
    case Fault::end_of_data:
      return "end of data";
    case Fault::silent:
      return "silent";
    case Fault::overflow:
      return "overflow";
    case Fault::bus_error:
      return "bus error";
    case Fault::bus_off:
      return "bus off";
    case Fault::untimely:
      return "untimely";
  }
  return "unknown";
}

}  // namespace dwell
