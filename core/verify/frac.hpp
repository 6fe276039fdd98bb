// The frequency response assurance criterion of a channel (W. Heylen and S. Lammens, FRAC: a consistent way of
// comparing frequency response functions, Proc. Int. Conf. on Identification in Engineering Systems, Swansea 1996):
//
//   FRAC = |Σ_f H_p(f) H_m*(f)|² / (Σ_f |H_p|² Σ_f |H_m|²)
//
// Each settled dwell gives one frequency f. H_m is measured there: the channel's phasor divided by the phasor of the
// table's displacement. H_p is the same ratio as the chain predicts it. FRAC = 1: the same shape over frequency; a
// common factor does not show. Two different frequencies are needed at least, since the chain was fitted at one of
// them.
#pragma once

#include <vector>

#include "core/model/chain.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Relative difference below which two frequencies count as one: the response is nearly the same at both.
inline constexpr double kSameFrequency = 0.01;

[[nodiscard]] bool same_frequency(const Dwell& a, const Dwell& b) noexcept;

// FRAC of each channel of the rig, in the channel's own quantity; NaN: the channel has fewer than two frequencies.
// `dwells` must be settled.
// Allocates; thread-safe.
[[nodiscard]] std::vector<double> frac(const Rig& rig, const Chain& chain, const std::vector<const Dwell*>& dwells);

}  // namespace dwell
