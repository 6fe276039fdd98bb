// How soon the method of any motion has all coefficients to 10 %: against the Cramér-Rao bound, and against the verdict
// of the harmonic method.
#pragma once

#include <cmath>

#include "tests/study/case.hpp"

namespace dwell::study {

// From the start of the motion, s. Coefficients: c and r of all elements that the harmonic method reports in the end.
struct MotionTimes {
  double harmonic_s = NAN;     // its verdict; NaN: none within 400 periods, or nothing reported
  double bound_s = NAN;        // the bound of all U95 falls to 10 %; NaN: not by the end of the dwell
  double seen_s = INFINITY;    // so does U95 as reported; infinite: not within six times the bound
  double noise = NAN;          // of the noisiest channel, over its amplitude
  double damping_ratio = NAN;  // of the least damped mode
};

// The table is taken as known up to amplitude and phase of its harmonics, frequency, offset and start. A case whose
// drive begins with the recording. The bound is looked for in steps of 5 % of the time. From it on estimates are made
// in steps of 15 %, and within the last of these in steps of 5 %.
[[nodiscard]] MotionTimes play_times(const Case& about);

}  // namespace dwell::study
