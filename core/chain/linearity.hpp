// Tests whether each element is linear, by the harmonics of the drive in its force and deformation.
//
// In a linear element harmonic h of the force is Z(hω) d_h = (c + jhωr) d_h, whatever the shaker does. The residual is
// e_h = f_h - (c + jhωr) d_h. Relative to the phase of the deformation, e_h exp(-jh arg d_1), the residual shows the
// kind of nonlinearity (docs/method.md, Linearity; steady motion a sin φ):
//
//   cubic spring c₃ d³       e_3 = -c₃a³/4           real, contributes + 3 |e_3|/a to c (c₃ < 0: -)
//   Coulomb friction F_c     e_3 = -j 4F_c/(3π)      imaginary, contributes + 3 |e_3|/(ωa) to r
//   quadratic damping r₂v|v| e_3 = +j 8r₂ω²a²/(15π)  imaginary, contributes + 5 |e_3|/(ωa) to r
//
// A law that is larger by the part g for one sign has e_2 = -j 2g/(3π) of its force (+j: a damper), and
// contributes g/2 to the coefficient: 3π/4 of e_2. With d² there is e_2 and no contribution, so this is the most.
//
// A transducer that distorts, y - βy³, adds a third harmonic ρ|X_1| in the phase of its reading, real ρ = βa²/4, and
// loses 3ρ of its fundamental. If one such ρ explains the residuals of several elements, that channel is named. One
// cause is likelier than several nonlinear elements that look like one, so the coefficients of these elements are then
// doubted: they are not equivalent ones, they are wrong.
//
// A warning needs a residual above five standard deviations and a contribution above the coefficient's U95. c and r are
// then equivalent coefficients, valid at this amplitude alone. A harmonic above a tenth of the force warns too.
#pragma once

#include <vector>

#include "core/chain/estimate.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct Linearity {
  std::vector<Warning> warnings;  // at most two per identifiable element, and one for channels that add harmonic 2
  std::vector<Doubt> doubts;      // at most one: channels that may distort
};

// elements: estimated from the same evidence. Harmonic 2 needs Excitation::harmonics >= 2, the other kinds 3.
// Allocates; O(harmonics · elements · (elements + channels)).
[[nodiscard]] Linearity judge_linearity(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                                        const Frequency& frequency, const std::vector<ElementEstimate>& elements);

}  // namespace dwell
