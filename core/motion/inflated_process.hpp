// Repeats a fit with the process noise of the table inflated: each intensity is at least a hundred times as large. The
// process then predicts less of the table's motion; the readings of the table count for more.
//
// Why: the process may be wrong, as for a table that moves in a swell or in a few tones. Such an error biases what the
// readings say of the chain, and their scatter does not show it. With inflated process noise the bias is smaller. The
// chain is known nearly as well as before if the table is read often enough to be known between its readings.
//
// If the process is right, an estimate and its repetition differ by chance. Their difference then has the difference of
// their variances as its variance: Hausman, Econometrica 46 (1978) 1251.
#pragma once

#include "core/motion/motion_course.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// course: of `rig`, with a fit. The noise of each channel stays at its value or grows, so that the process cannot take
// it up. The fit of what is returned may not have converged. Costs one fit from the course's end. Allocates;
// thread-safe. Throws Stopped soon after the course's stop was requested.
[[nodiscard]] MotionCourse with_inflated_process_noise(const Rig& rig, const MotionCourse& course);

}  // namespace dwell
