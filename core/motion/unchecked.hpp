// Combinations of terms that change no reading, so that no data of the rig can tell them. One is the common scale of
// all masses of a free chain: all coefficients grow with it.
#pragma once

#include <string>
#include <vector>

#include "core/motion/score_test.hpp"

namespace dwell {

// "the common scale of mass 1 and mass 2", "the common delay of y0, y1 and y2"; of masses, scales and delays, which a
// rig file states. Allocates; thread-safe.
[[nodiscard]] std::vector<std::string> unchecked(const Rig& rig, const ScoreTest& test);

}  // namespace dwell
