// What no passive element has: a negative stiffness or damping. Where one comes out, beyond what its uncertainty
// allows, something that the uncertainty does not cover is wrong: a sign, the order of two channels, a unit, an
// instant, a mass. The same wrong reading is in every other element computed from those channels, wherever it may show
// a plausible number.
#pragma once

#include <vector>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Withholds each element with a stiffness or damping below -U95, with value ± U95 as the reason, and raises one doubt:
// of all elements that share a channel with one of them where it is below -2 U95; of itself alone where it is not,
// since an element without any damping comes out below -U95 in one of forty dwells. used: per element, per channel,
// whether it is computed from it. Allocates.
void refuse_negative(const Rig& rig, const std::vector<std::vector<bool>>& used, std::vector<ElementEstimate>& elements,
                     std::vector<Doubt>& doubts);

}  // namespace dwell
