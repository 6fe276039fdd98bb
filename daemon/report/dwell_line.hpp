// A dwell as one line of log, for people.
#pragma once

#include <string>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// "dwell 3 complete (drive stopped): 4.0003 Hz, 22.1 s counted; c_1 = 24.010 ± 0.027 kN/m, …"; ± is U95. An element
// without coefficients says why. Doubts and warnings follow, and what ± does not cover.
[[nodiscard]] std::string finished_line(const Dwell& dwell, const Rig& rig);

// "state idle -> settling: …", with what the new state rests on.
[[nodiscard]] std::string state_line(State before, const Dwell& now);

}  // namespace dwell
