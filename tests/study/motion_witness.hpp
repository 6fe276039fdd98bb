// What the method of any motion objects to a dwell that was played: `identify` prints it beside the dwell.
#pragma once

#include <string>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

// Estimates any motion from the case's readings up to until_s, and searches for what is missing. One line per
// objection: why there are no coefficients; or the warnings, what becomes a doubt of a dwell, and which coefficient
// contradicts a dwell's. Empty: no objection. Takes seconds, up to minutes where instants are irregular.
[[nodiscard]] std::vector<std::string> objections_of_motion(const Case& about, double until_s);

}  // namespace dwell::study
