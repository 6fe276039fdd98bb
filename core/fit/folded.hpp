// Bounds the error by harmonics of the drive that are not fitted and that a channel's sampling folds onto the
// fundamental.
//
// Sampled at k times the drive's frequency f, harmonics k - 1 and k + 1 read exactly as the fundamental. No fit
// separates them and the data do not bound them. So a typical drive's limit is assumed: an error of the phasor within ±
// kLargest/m of the amplitude, as a source of uncertainty (docs/method.md, Uncertainty). Irregular instants weaken an
// alias. An alias that turns within the dwell averages out and shows as scatter.
#pragma once

#include <vector>

#include "core/fit/mains.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct Folded {
  int order = 0;         // of the harmonic with the largest effect; 0: none folds
  double part = 0.0;     // that effect in parts of the fundamental's amplitude: half width of a rectangle
  bool exactly = false;  // nothing within the dwell shows it
};

// The worst such harmonic of one channel, its transducer divided out. sampling: of that channel. f: the drive's
// frequency, Hz. seconds: length of the data that count. Thread-safe, no allocation.
[[nodiscard]] Folded folded_onto_fundamental(const Rig& rig, const Channel& channel, const SamplingRegularity& sampling,
                                             double f, double seconds) noexcept;

// Adds a warning to `dwell` for each harmonic that folds exactly, with its channels. folded: per channel. Allocates.
void warn_of_folded(const Rig& rig, const std::vector<Folded>& folded, Dwell& dwell);

}  // namespace dwell
