// Withholds elements with a negative stiffness or damping, which no passive element has.
//
// A coefficient that is negative beyond its uncertainty shows another error: a wrong sign, order of channels, unit,
// instant or mass. Every other element computed from those channels has the same error, even with plausible numbers.
#pragma once

#include <vector>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Withholds each element with c or r below -U95, with value ± U95 as the reason, and raises one doubt. If one of these
// is below -2 U95, the doubt names all elements that share a channel with a withheld one. Otherwise it names the
// withheld ones alone: an element without damping comes out below -U95 in one of forty dwells. used: per element and
// channel, whether the element is computed from the channel. Allocates.
void refuse_negative(const Rig& rig, const std::vector<std::vector<bool>>& used, std::vector<ElementEstimate>& elements,
                     std::vector<Doubt>& doubts);

}  // namespace dwell
