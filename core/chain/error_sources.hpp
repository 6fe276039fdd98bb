// Lists all error sources of a dwell, from rig file and data, each with the effect of one standard deviation.
//
// An error is the assumed minus the true value. o is the displacement or force that a channel observes, x = gain·o:
//
//   δZ_k = [ ω² Σ_{i>=k} (m_i δY_i + Y_i δm_i) + 2ω Σ_{i>=k} m_i Y_i δω - δF - Z_k δd_k ] / d_k
//   δZ_{n+1} = (δF - Z_{n+1} δY_n) / Y_n
//   δo = noise + o δs/s + jωo δτ - o ∂ln H/∂f_c δf_c - o (q/ω + H'/H) δω ,   to second order by δτ: -o (ω δτ)²/2
//
//   s scale, τ instant (delay, turnaround, refresh, uneven readings), H filters and delay, f_c corner of a filter, q
//   order of the measured derivative
//
// Noise is type A, with the degrees of freedom of its residuals. All other sources are type B, with infinite degrees of
// freedom. An error that several channels share is one source: the delay of a device, the turnaround of a transaction,
// a mass, ω, the clock rate. Source: docs/method.md, Uncertainty; GUM, JCGM 100, 4.2 and 4.3.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/chain/chain_state.hpp"
#include "core/chain/evidence.hpp"
#include "core/chain/propagation.hpp"
#include "core/rig/observation.hpp"

namespace dwell {

// o: displacement or force that each channel observes, 0 if not usable. chain.x = gain·o; elements: of `chain`, at
// frequency.omega. Sources of zero size are left out. Allocates; O(channels · elements).
[[nodiscard]] std::vector<ErrorSource> sources_of(const Gain& gain, const std::vector<Evidence>& evidence,
                                                  const Eigen::VectorXcd& o, const ChainState& chain,
                                                  const ElementStates& elements, const Frequency& frequency);

}  // namespace dwell
