// Whether what is noise by the fit, in a channel of the table, cannot be noise: the readings err in a pattern.
//
// Of the innovations' variance a part ε is motion that could not be foreseen, the rest noise of the readings. Whatever
// that motion is, it correlates them by no more than ε + 2 √(ε (1 - ε)) (Cauchy and Schwarz). So a table that moves
// otherwise than its process is excused: its ε is large. A larger correlation is one of errors, and their variance is
// at least their covariance. Source: docs/method.md, Any motion, What it says about itself.
#pragma once

#include <cstddef>
#include <string>

#include "core/motion/likelihood.hpp"
#include "core/motion/whiteness.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// The least rms of the pattern, in units of u_noise; 0: there is none. innovations: of channel c in `pass`. White ones
// have one by chance in less than a millionth of all estimates. Pure.
[[nodiscard]] double pattern_in_noise(const Pass& pass, std::size_t c, double u_noise, const Whiteness& innovations);

// How far rounding alone can err: half the least difference of two readings of the channel, one after the other, that
// differ; 0: none do. O(readings).
[[nodiscard]] double error_of_rounding(const MotionData& data, int channel);

// at_least: the pattern, as a part of the channel's motion.
[[nodiscard]] std::string words_of_pattern(const Channel& channel, double at_least);

}  // namespace dwell
