// A first cross-check of the model: the poles that the transient shows against the eigenvalues of the chain that the
// steady motion identifies (docs/method.md, Cross-check).
//
// The coefficients of one frequency reproduce that frequency whatever the masses are. The natural oscillations are
// independent evidence: their poles follow from instants alone. Where masses, units, delays or connections are other
// than the rig file says, the two part.
//
//   Δ = λ_data - λ_chain,   χ² = Δ' (Cov λ_data + Cov λ_chain)⁻¹ Δ,   two real numbers a mode
//
// Cov λ_chain propagates every source of the budget through ∂λ/∂c, ∂λ/∂r and, for a mass, ∂λ/∂m. The clock's rate is
// left out: it moves both by the same part.
#pragma once

#include <span>

#include "core/estimate.hpp"
#include "core/rig.hpp"
#include "core/seen_modes.hpp"

namespace dwell {

// Adds a doubt for the mode that contradicts most, with figures, and what single fault would explain all modes. omega:
// rad/s, of the drive. Allocates; O(n³).
void check_poles(const Rig& rig, const ElementsResult& identified, double omega, std::span<const SeenMode> seen,
                 Dwell& dwell);

}  // namespace dwell
