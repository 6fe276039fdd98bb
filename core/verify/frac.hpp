// The frequency response assurance criterion of a channel (W. Heylen and S. Lammens, FRAC: a consistent way of
// comparing frequency response functions, Proc. Int. Conf. on Identification in Engineering Systems, Swansea 1996):
//
//   FRAC = |Σ_f H_p(f) H_m*(f)|² / (Σ_f |H_p|² Σ_f |H_m|²)
//
// H_m is the channel's measured phasor over that of the table's displacement, one for each settled dwell, H_p what the
// chain gives at that frequency. 1: the same shape over frequency; a common factor does not show. The dwell that gave
// the chain is one of the frequencies, where both agree by construction, so at least two different ones are needed.
#pragma once

#include <vector>

#include "core/model/chain.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Frequencies that differ by less than this part are one: a response hardly changes from one to the other.
inline constexpr double kSameFrequency = 0.01;

[[nodiscard]] bool same_frequency(const Dwell& a, const Dwell& b) noexcept;

// Per channel of the rig, in its own quantity; NaN where fewer than two frequencies are known of it. dwells: settled.
// Allocates; thread-safe.
[[nodiscard]] std::vector<double> frac(const Rig& rig, const Chain& chain, const std::vector<const Dwell*>& dwells);

}  // namespace dwell
