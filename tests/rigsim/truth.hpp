// What a measurement of the simulated rig ought to find, as one line of JSON.
#pragma once

#include <string>

#include "core/model/chain.hpp"
#include "core/model/driven_chain.hpp"

namespace rigsim {

// {"boundary", "masses", "stiffness", "damping", "frequency_hz", "offset", "slowest_decay_per_s",
//  "phasors": [{"channel", "unit", "amplitude", "phase_rad"}]}: SI, phases relative to the table's. Steady state.
[[nodiscard]] std::string truth_json(const dwell::Chain& chain, const dwell::Drive& drive);

}  // namespace rigsim
