// Random chains and their transducers; the parts of draw() that know no disturbance.
#pragma once

#include "tests/study/case.hpp"

namespace dwell::study {

struct DrawnChain {
  Chain chain;
  std::string remark;
};

// n = 1 … 6, both boundaries; every mode's damping ratio within 0.3 … 20 %; the drive anywhere against the modes:
// about one, within 1 % of one, far above the slowest, or where a mass is a node.
[[nodiscard]] DrawnChain draw_chain(Draws& draws, double frequency_hz);

// A displacement transducer on the table and a transducer on every mass, some of them across an element or of another
// quantity, and a load cell if clamped: fills rig.channels and sensors.
void draw_channels(Draws& draws, Case& about);

}  // namespace dwell::study
