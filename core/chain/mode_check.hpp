// A first cross-check of the model: the natural oscillations that the transient shows against the chain that the steady
// motion identifies (docs/method.md, Cross-check).
//
// The coefficients of one frequency reproduce that frequency whatever the masses are. The natural oscillations are
// independent evidence: the same equations must hold with their poles and amplitudes (core/chain/mode_residual.hpp).
// Where masses, units, delays or connections are other than the rig file says, they do not.
#pragma once

#include <span>

#include "core/chain/estimate.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/seen_modes.hpp"

namespace dwell {

// Adds a doubt for the mode that contradicts most, with figures, and what single fault would explain all modes. omega:
// rad/s, of the drive. Allocates; O(n³ + channels² · n) a mode; where there is a doubt O(n⁴), as n² faults are tried.
void check_modes(const Rig& rig, const ElementsResult& identified, double omega, std::span<const SeenMode> seen,
                 Dwell& dwell);

}  // namespace dwell
