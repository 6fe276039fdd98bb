// The same fit beside a table of which the process foretells less: each intensity is a hundred times as large or
// larger, the noise of each channel no smaller. A table that moves more regularly than its process has it, in swells or
// tones, biases what the readings say of the chain, and no scatter shows that. Beside the freer table that bias is
// smaller, and the chain is known nearly as well as long as the table itself is measured.
//
// If the process is right, an estimate and its repetition beside the freer table differ by chance, with the difference
// of their variances: Hausman, Econometrica 46 (1978) 1251.
#pragma once

#include "core/motion/motion_course.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// course: fitted. O(a fit from there, some ten passes). Its fit may have not converged. Allocates; thread-safe.
[[nodiscard]] MotionCourse with_freer_table(const Rig& rig, const MotionCourse& course);

}  // namespace dwell
