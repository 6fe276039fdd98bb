// What the coefficients of any motion say of a dwell that was played: `identify` and the service print them beside it.
#pragma once

#include "tests/study/disturbed.hpp"

namespace dwell::study {

// Estimates from the case's readings up to until_s, without the search for what is missing. Tells why there are no
// coefficients, or whether they contradict a dwell's. Takes seconds, up to minutes where instants are irregular.
void tell_motion(const Case& about, double until_s, const Trace& trace);

}  // namespace dwell::study
