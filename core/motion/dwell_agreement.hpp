// Whether the coefficients of any motion agree with those of a dwell of the same rig.
//
// What the rig file states with an uncertainty moves both alike; what differs is noise. Where the motion's stretch
// holds all that the dwell counts, the estimate from more data is the more efficient one, and the variance of the
// difference is that of the variances (Hausman 1978); else at most their sum.
#pragma once

#include "core/result/motion.hpp"

namespace dwell {

// The largest |difference| / (2 u of the difference) over all coefficients that both have; NaN: there is none.
// Above 1 they contradict each other.
[[nodiscard]] double agreement_e_n(const MotionEstimate& motion, const Dwell& dwell);

}  // namespace dwell
