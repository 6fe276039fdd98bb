// The coefficients that a simulated rig really has, beside those that were measured.
#pragma once

#include <string>
#include <tl/expected.hpp>

#include "daemon/report/dwell_text.hpp"

namespace dwell::ctl {

// A JSON file with "stiffness" and "damping", arrays of SI numbers, one per element.
[[nodiscard]] tl::expected<Truth, std::string> read_truth(const std::string& path);

// Whether every coefficient of the truth was identified and lies within `most_u` standard uncertainties of it; else the
// first that does not is named in `why`.
[[nodiscard]] bool agrees(const Dwell& dwell, const Truth& truth, double most_u, std::string& why);

}  // namespace dwell::ctl
