#include "tests/study/disturbance.hpp"

namespace dwell::study {

const char* name_of(Kind kind) {
  switch (kind) {
    case Kind::refresh_one:
      return "refresh, one channel";
    case Kind::refresh_all:
      return "refresh, all channels";
    case Kind::clip_both:
      return "clipped, both sides";
    case Kind::clip_one:
      return "clipped, one side";
    case Kind::end_codes:
      return "end codes";
    case Kind::zeros_one:
      return "zeros, one channel";
    case Kind::zeros_all:
      return "zeros, whole scans";
    case Kind::repeats_one:
      return "repeats, one channel";
    case Kind::repeats_all:
      return "repeats, whole scans";
    case Kind::bursts:
      return "bursts of holds";
    case Kind::alternate:
      return "every second stale";
    case Kind::glitch_rounded:
      return "glitch, rounded";
    case Kind::low_byte:
      return "low byte stuck";
    case Kind::folded:
      return "folded harmonics";
    case Kind::stations:
      return "two stations";
    case Kind::fixed_off:
      return "fixed frequency off";
    case Kind::hunting:
      return "hunting amplitude";
    case Kind::hunting_short:
      return "hunting, short dwells";
    case Kind::drift:
      return "amplitude drift";
    case Kind::friction:
      return "friction";
    case Kind::cubic:
      return "cubic spring";
    case Kind::side_ground:
      return "spring to ground";
    case Kind::side_between:
      return "spring between masses";
    case Kind::mass_off:
      return "mass off";
    case Kind::wrong_scale:
      return "wrong unit or gain";
    case Kind::late:
      return "channel late";
    case Kind::swapped:
      return "channels swapped";
    case Kind::reversed:
      return "load cell reversed";
  }
  return "";
}

bool is_of_model(Kind kind) { return kind >= Kind::friction; }

}  // namespace dwell::study
