// What the method of any motion says of a dwell that was played: `identify` and the service print it beside the dwell.
#pragma once

#include <string>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

// Why there are no coefficients, or which contradict a dwell's, and what is warned of; of the case's readings up to
// until_s, without the search for what is missing. Takes seconds, up to minutes where instants are irregular.
[[nodiscard]] std::vector<std::string> told_by_motion(const Case& about, double until_s);

}  // namespace dwell::study
