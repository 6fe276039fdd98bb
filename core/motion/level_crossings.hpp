// Readings that are rounded more coarsely than their noise, as an encoder's are.
//
// Such a reading does not change between two steps, so that its error follows the motion. At a change the motion is
// known better: it passes the edge between the two levels. Each pair of consecutive readings therefore gives
//
//   no reading                          where both are equal
//   the edge, midway between both       where they are neighbouring levels; uniform within the interval, white
//   the second of them, as it stands    where they are farther apart: the error of rounding is then white
//                                       (Widrow and Kollár 2008, chapter 5)
//
// Noise σ beside a step q smooths the rounding. The error that follows the motion has the mean square
// q²/(2π²) exp(-4π²σ²/q²): below 1 % of all noise from σ = 0.3 q on, and readings stay as they are.
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// data: by time, and so afterwards. noise: per channel, SI, as local_noise(). Returns the channels that it changed.
// Allocates; thread-safe; O(readings).
std::vector<int> take_level_crossings(const Rig& rig, const std::vector<double>& noise, MotionData& data);

}  // namespace dwell
