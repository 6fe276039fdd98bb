// Whether an element is linear, by the harmonics of the drive that its own force and deformation hold.
//
// In a linear element harmonic h of the force is Z(hω) d_h = (c + jhωr) d_h, whatever the shaker does. What is left of
// it, e_h = f_h - (c + jhωr) d_h, turned to the phase of the deformation, e_h exp(-jh arg d_1), tells what kind it is
// of (docs/method.md, Linearity; steady motion a sin φ):
//
//   cubic spring c₃ d³       e_3 = -c₃a³/4           real, c holds + 3 |e_3|/a of it (c₃ < 0: -)
//   Coulomb friction F_c     e_3 = -j 4F_c/(3π)      imaginary, r holds + 3 |e_3|/(ωa) of it
//   quadratic damping r₂v|v| e_3 = +j 8r₂ω²a²/(15π)  imaginary, r holds + 5 |e_3|/(ωa) of it
//
// A transducer that compresses or stretches what it measures, y - βy³, holds a third harmonic ρ|X_1| in the phase of
// its reading, real ρ = βa²/4, and loses 3ρ of its fundamental. Where one such ρ explains what several elements show,
// that channel is named: no single element does.
//
// A harmonic is told of where five of its standard deviations do not explain it and where the part of c or r that it
// stands for exceeds that coefficient's U95: c and r are then equivalent coefficients, of this amplitude alone.
#pragma once

#include <string>
#include <vector>

#include "core/chain/estimate.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// At most one warning per identifiable element, and one for the channels. elements: as estimated from the same
// evidence. Needs Excitation::harmonics >= 3: fewer show none of the above. Allocates; O(harmonics · elements ·
// (elements + channels)).
[[nodiscard]] std::vector<std::string> judge_linearity(const Rig& rig, const Gain& gain,
                                                       const std::vector<Evidence>& evidence,
                                                       const Frequency& frequency,
                                                       const std::vector<ElementEstimate>& elements);

}  // namespace dwell
