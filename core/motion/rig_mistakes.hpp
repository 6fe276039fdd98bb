// Mistakes of a rig file that no small number describes: a channel whose sign is wrong, two channels that stand in each
// other's place. Each is tried by taking the readings as they would be without it, and fitting the chain anew.
#pragma once

#include <string>
#include <vector>

#include "core/motion/leftover.hpp"
#include "core/motion/likelihood.hpp"
#include "core/motion/motion_course.hpp"

namespace dwell {

struct RigMistake {
  int channel = -1;
  int other = -1;  // swapped with; -1: the channel's sign is wrong
};

// All that can be thought of for this rig.
[[nodiscard]] std::vector<RigMistake> rig_mistakes(const Rig& rig);
// "y1 and y2 swapped", "sign of reaction".
[[nodiscard]] std::string name_of(const Rig& rig, const RigMistake& mistake);
// As a part of a sentence: "y1 and y2 swapped", "the opposite sign of reaction".
[[nodiscard]] std::string in_words(const Rig& rig, const RigMistake& mistake);

// The readings without that mistake: a swapped one is what the other channel makes of the device's number.
[[nodiscard]] MotionData without(const Rig& rig, const MotionData& data, const RigMistake& mistake);

// How well the chain fits readings: per reading, so that fits of not quite the same readings compare.
struct ChainFit {
  bool possible = false;     // converged, and no coefficient is negative beyond its uncertainty
  double per_reading = 0.0;  // V of each, of the device's numbers
  double readings = 0.0;
  Leftover left;
};
// course: of readings as `without(mistake)` gives them.
[[nodiscard]] ChainFit chain_fit(const Rig& rig, const MotionCourse& course);
// Negative beyond four standard uncertainties: no chain has it.
[[nodiscard]] bool has_impossible_coefficient(const Rig& rig, const MotionFit& fit);

}  // namespace dwell
