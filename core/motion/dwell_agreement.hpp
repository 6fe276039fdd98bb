// Whether the coefficients of any motion agree with those of a dwell of the same rig.
//
// Errors of what the rig file states move both alike; noise makes the difference d. Where the stretch of the motion
// holds all readings of the dwell, the motion's estimate uses more and is the more efficient one, and Hausman (1978)
// gives
//
//   var d = u_dwell² - u_motion²   (of the parts of noise);   var d = u_dwell² + u_motion² where the readings differ
#pragma once

#include "core/result/motion.hpp"

namespace dwell {

// The largest |difference| / (2 u of the difference) over all coefficients that both have; NaN: there is none.
// Above 1 they contradict each other.
[[nodiscard]] double agreement_e_n(const MotionEstimate& motion, const Dwell& dwell);

}  // namespace dwell
