// Whether the coefficients of any motion agree with those of a dwell of the same rig.
//
// An error of the rig file, such as a wrong mass, shifts both estimates alike. Only noise makes them differ, and what
// one of them does not see: a bent spring, instants that are off, readings that are held. Let d be the difference of a
// coefficient, and u_dwell and u_motion its standard uncertainties by noise alone:
//
//   var d = u_dwell² - u_motion²   if the motion's stretch holds all readings of the dwell (Hausman 1978: the motion's
//                                  estimate uses more of them and is the more efficient one)
//   var d = u_dwell² + u_motion²   if it does not: the noise is then taken as independent
#pragma once

#include "core/result/motion.hpp"

namespace dwell {

// Compares all c and r that both have. A function of its arguments; some operations per coefficient.
[[nodiscard]] Agreement agreement_of(const MotionEstimate& motion, const Dwell& dwell);

}  // namespace dwell
