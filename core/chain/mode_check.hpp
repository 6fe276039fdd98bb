// Cross-check of the model: compares the natural oscillations in the transient with the chain identified from the
// steady motion (docs/method.md, Cross-check).
//
// Coefficients from one frequency reproduce that frequency, even with wrong masses. The natural oscillations are
// independent evidence: their poles and amplitudes must satisfy the same equations (core/chain/mode_residual.hpp). The
// equations fail if masses, units, delays or connections differ from the rig file.
#pragma once

#include <span>

#include "core/chain/estimate.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/seen_modes.hpp"

namespace dwell {

// Adds at most one doubt, for the mode that contradicts most, with figures and the single faults that would explain all
// modes. omega: of the drive, rad/s. Allocates. O(n³ + channels² · n) per mode; with a doubt O(n⁴), for n² faults.
void check_modes(const Rig& rig, const ElementsResult& identified, double omega, std::span<const SeenMode> seen,
                 Dwell& dwell);

}  // namespace dwell
