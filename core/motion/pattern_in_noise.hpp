// Finds a pattern in the readings of the table's transducer: an error that the fit takes for noise, and that no noise
// can be.
//
// The innovations' variance is noise of the readings, but for a part ε that is motion which could not be foreseen.
// Whatever that motion is, it correlates the innovations by no more than ε + 2 √(ε (1 - ε)) (Cauchy and Schwarz). A
// table that moves otherwise than its process has a large ε, and is excused. Where the correlation is larger, the
// readings err. The variance of that error is at least its covariance. Source: docs/method.md, Any motion, What it says
// about itself.
#pragma once

#include <cstddef>
#include <string>

#include "core/motion/likelihood.hpp"
#include "core/motion/whiteness.hpp"
#include "core/result/motion.hpp"

namespace dwell {

// The rms of the pattern is at least this, in the unit of u_noise; 0: there is none. u_noise: standard deviation of the
// channel's noise as fitted. innovations: of channel c in `pass`. White noise alone is taken for a pattern in less than
// one of a million estimates. Pure.
[[nodiscard]] double pattern_in_noise(const Pass& pass, std::size_t c, double u_noise, const Whiteness& innovations);

// The largest error that rounding makes, SI: half the smallest step from one reading of the channel to the next; 0: its
// readings are all the same. O(readings). Pure.
[[nodiscard]] double error_of_rounding(const MotionData& data, int channel);

// The channel, by how much it errs, what shows it and what may cause it: "the readings of y0 err in a pattern, …". What
// that means for a ± is added by whoever states the ±. The last sentence has no full stop. Thread-safe; allocates.
[[nodiscard]] std::string words_of_pattern(const ReadingsPattern& pattern);

}  // namespace dwell
