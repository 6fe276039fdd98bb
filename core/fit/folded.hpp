// Harmonics of the drive beyond those fitted that a channel's sampling folds onto the fundamental.
//
// Sampled at a rate that is k times the drive's frequency f, harmonics k - 1 and k + 1 read exactly as the fundamental,
// and no fit tells them apart. Nothing in the data bounds them, so their size is taken from what drives do: an error of
// the phasor within ± kLargest/m of the amplitude, as a source of uncertainty (docs/method.md, Uncertainty). Irregular
// instants spread an alias, and one that turns within the dwell averages out and shows as scatter.
#pragma once

#include <vector>

#include "core/fit/mains.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct Folded {
  int order = 0;         // of the harmonic that may do most; 0: none folds
  double part = 0.0;     // of the fundamental's amplitude, that it may add: the half width of a rectangle
  bool exactly = false;  // nothing within the dwell can tell
};

// sampling: of that channel, whose transducer is divided out. f: the drive's frequency, Hz; fitted: harmonics in the
// fit; seconds: of data that count. Thread-safe, no allocation.
[[nodiscard]] Folded folded_onto_fundamental(const Rig& rig, const Channel& channel, const SamplingRegularity& sampling,
                                             double f, double seconds) noexcept;

// Says which harmonics fold exactly in which channels. folded: per channel. Allocates.
void warn_of_folded(const Rig& rig, const std::vector<Folded>& folded, Dwell& dwell);

}  // namespace dwell
