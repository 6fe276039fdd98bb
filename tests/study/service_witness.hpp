// What the service says beside a live dwell that was played: the estimate from its transient, and the verification of
// its model. `status`, `watch`, `verify` and the page show it.
#pragma once

#include <string>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

// Plays the case's stream up to until_s as the service does. Its long work takes no time here, so that each estimate is
// as new as the service's can be. One line for each thing that speaks against the coefficients: why the transient gives
// none, the coefficient of it that contradicts the dwell's, and of a model that is not consistent or not adequate the
// reasons and the causes. Takes seconds, up to minutes.
[[nodiscard]] std::vector<std::string> objections_of_service(const Case& about, double until_s);

}  // namespace dwell::study
