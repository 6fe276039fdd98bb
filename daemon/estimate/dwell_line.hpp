// A dwell as one line of log, for people.
#pragma once

#include <string>

#include "core/dwell.hpp"
#include "core/rig.hpp"

namespace dwell {

// "dwell 3 complete (drive stopped): 4.0003 Hz, c_1 = 24010 ± 27 N/m, r_1 = 60.2 ± 0.8 N*s/m, …"; ± is U95. An element
// without coefficients says why.
[[nodiscard]] std::string finished_line(const Dwell& dwell, const Rig& rig);

// "state idle -> settling: …", with what the new state rests on.
[[nodiscard]] std::string state_line(State before, const Dwell& now);

// value ± half_width, rounded to two digits of half_width. Not finite: "none".
[[nodiscard]] std::string interval(double value, double half_width);

}  // namespace dwell
