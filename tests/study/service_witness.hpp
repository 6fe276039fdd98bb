// Plays a dwell as the service does, and gathers what it says beside the dwell: the estimate from the transient, and
// the verification of the model. `status`, `watch`, `verify` and the page show both.
#pragma once

#include <string>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

// Plays the case's stream up to until_s. Long work takes no time here, so each estimate is as new as the service's can
// be. One line for each thing that speaks against the coefficients: why the transient gives none; which coefficient
// from the transient contradicts the dwell's; and, if the model is not consistent or not adequate, the reasons and the
// causes. Empty: nothing does. Takes seconds, up to minutes.
[[nodiscard]] std::vector<std::string> objections_of_service(const Case& about, double until_s);

}  // namespace dwell::study
